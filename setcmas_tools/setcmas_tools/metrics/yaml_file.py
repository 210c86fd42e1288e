"""The file metrics.yaml: the metrics of a run, the same bytes for equal runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.errors import SetcmasError
from setcmas_tools.metrics.compute import Metrics

FILE_NAME = 'metrics.yaml'

_DIGITS = 6


class _Dumper(yaml.SafeDumper):
    """Writes lists in one line."""

    def represent_list(self, data: Any) -> yaml.SequenceNode:
        return self.represent_sequence('tag:yaml.org,2002:seq', data, flow_style=True)


_Dumper.add_representer(list, _Dumper.represent_list)


def as_dict(metrics: Metrics) -> dict[str, Any]:
    """Return metrics as plain values in a fixed order, rounded."""
    head = {
        'task': metrics.task,
        'duration_s': metrics.duration_s,
        'vnom_m_s': metrics.vnom_m_s,
        'communication': metrics.communication,
    }
    parts = {name: part.as_dict() for name, part in metrics.items() if part.in_file}
    return {name: _rounded(value) for name, value in (head | parts).items() if value is not None}


def write_yaml(metrics: Metrics, path: Path) -> None:
    """Write metrics with 6 significant digits.

    Raises:
        SetcmasError: The file cannot be written.
    """
    text = yaml.dump(as_dict(metrics), Dumper=_Dumper, sort_keys=False, width=98)
    try:
        path.write_text(text, encoding='utf-8', newline='\n')
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    if isinstance(value, float):
        return float(f'{value:.{_DIGITS}g}') + 0.0  # + 0.0: no minus before zero
    return value
