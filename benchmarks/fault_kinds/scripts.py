"""Control scripts that fail while robots move."""

from __future__ import annotations

from fault_kinds.kind import Kind


def _mode(mode: str, line: str) -> Kind:
    return Kind(lambda r: r.set_mode(mode), line, lambda r: r.set_mode(''))


KINDS = {
    'script stuck': _mode('stuck', 'has not returned'),
    'script slow, 1 s': _mode('slow', 'no command|takes'),
    'script NaN': _mode('nan', 'nan'),
    'script infinite': _mode('inf', 'inf'),
    'script returns None': _mode('none', 'None'),
    'script returns three values': _mode('three', r'three|3'),
    'script raises': _mode('raise', 'ZeroDivisionError'),
    'script calls sys.exit': _mode('exit', 'SystemExit|sys.exit|exit'),
    'script calls os._exit': _mode('kill', 'ended|exit'),
}
