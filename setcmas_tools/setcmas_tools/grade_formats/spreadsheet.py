"""Tables as CSV text that spreadsheets do not take for formulas."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

_UTF_8 = '\ufeff'  # by which Excel knows the encoding; Moodle and Canvas take it off, too
_FORMULA = ('=', '+', '-', '@', '\t', '\r')


def csv_text(rows: Iterable[Iterable[str | float]]) -> str:
    """Return rows as CSV; texts that a spreadsheet would compute begin with an apostrophe."""
    text = io.StringIO()
    csv.writer(text, lineterminator='\n').writerows(map(_safe, row) for row in rows)
    return _UTF_8 + text.getvalue()


def _safe(cell: str | float) -> str | float:
    if not isinstance(cell, str):
        return f'{cell:.6g}'
    plain = ' '.join(''.join(c if c.isprintable() else ' ' for c in cell).split())
    return f"'{plain}" if cell.startswith(_FORMULA) else plain
