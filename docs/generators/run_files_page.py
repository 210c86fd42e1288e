"""CSV files of a run, for the page on them."""

from __future__ import annotations

from setcmas_tools.run.run_tables import CSV_FILES


def text() -> str:
    """Return a table of each file's columns."""
    lines = []
    for file in CSV_FILES:
        lines += [f'## {file.name}', '', f'{file.meaning[0].upper()}{file.meaning[1:]}.', '']
        lines += ['| column | |', '|---|---|']
        columns = (*file.columns, *file.further)
        lines += [f'| `{column.name}` | {column.meaning} |' for column in columns]
        lines.append('')
    return '\n'.join(lines)
