"""A table of texts, for the terminal and for pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from itertools import zip_longest

_GAP = '  '
_AROUND_HEAD = 2  # letters that a column is wider than its head, so that the rule shows columns


@dataclass(frozen=True)
class Table:
    """Rows of texts, with heads of one line or more, or none; `str` aligns their columns.

    `align` has 'l' or 'r' for each column; the last letter holds for all others.
    """

    rows: Sequence[Sequence[str]]
    heads: Sequence[str] = ()
    align: str = 'l'

    def __str__(self) -> str:
        """Return aligned lines, the heads above a rule; empty without rows."""
        if not self.rows:
            return ''
        heads = list(zip_longest(*(head.split('\n') for head in self.heads), fillvalue=''))
        columns = list(zip(*self.rows, strict=True))
        least = [max(map(len, head.split('\n'))) + _AROUND_HEAD for head in self.heads]
        widths = [
            max([width, *map(len, column)])
            for width, column in zip(least or [0] * len(columns), columns, strict=True)
        ]
        rule = [['-' * width for width in widths]] if heads else []
        lines = (self._line(cells, widths) for cells in [*heads, *rule, *self.rows])
        return '\n'.join(lines)

    def html(self) -> str:
        """Return an HTML table, empty without rows; all texts are escaped."""
        if not self.rows:
            return ''
        rows = [self._row('td', row) for row in self.rows]
        body = '\n'.join(['<tbody>', *rows, '</tbody>'])
        head = f'<thead>\n{self._row("th", self.heads)}\n</thead>\n' if self.heads else ''
        return f'<table>\n{head}{body}\n</table>'

    def _line(self, cells: Iterable[str], widths: Iterable[int]) -> str:
        texts = (
            cell.rjust(width) if self._is_right(column) else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(cells, widths, strict=True))
        )
        return _GAP.join(texts).rstrip()

    def _row(self, kind: str, cells: Sequence[str]) -> str:
        right = ' style="text-align: right;"'
        texts = (
            f'<{kind}{right if self._is_right(column) else ""}>{escape(cell)}</{kind}>'
            for column, cell in enumerate(cells)
        )
        return f'<tr>{"".join(texts)}</tr>'

    def _is_right(self, column: int) -> bool:
        return self.align[min(column, len(self.align) - 1)] == 'r'
