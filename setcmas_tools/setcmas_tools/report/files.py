"""The file of a report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_tools.pages.page import write_page
from setcmas_tools.report.page import report_page
from setcmas_tools.report.pair import Pair
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import find_run

_ENDINGS = ('.html', '.htm')


def page_named_after(run: Path) -> Path:
    """Return the page of a run in the current folder.

    Raises:
        SetcmasError: There is no run.
    """
    return Path(f'{_name_of(run)}.html')


def check_page(page: Path) -> None:
    """See that a page can be written to a file.

    Raises:
        SetcmasError: It cannot.
    """
    if page.suffix.lower() not in _ENDINGS:
        raise SetcmasError(f"the page '{page}' must end with .html")
    if not page.parent.is_dir():
        raise SetcmasError(
            f"the page '{page}' cannot be written: there is no folder '{page.parent}'; create it"
        )


def write_report(paths: Sequence[Path], page: Path, warn: Callable[[str], None]) -> None:
    """Write the page of a run.

    Args:
        paths: The run, and perhaps another one beside it.
        page: The file.
        warn: Shows what is left out.

    Raises:
        SetcmasError: A run cannot be read, or the page cannot be written.
    """
    named = [(_name_of(path), Run.load(path, warn)) for path in paths]
    (name, run), (other_name, other) = [*named, ('', None)][:2]
    assert run
    pair = Pair(name, run, other_name, other, warn, paths)
    try:
        write_page(page, report_page(pair))
    except OSError as error:
        raise SetcmasError(f"'{page}' cannot be written: {error.strerror}") from error


def _name_of(path: Path) -> str:
    """Return what a run is called: as its folder, or as its recording.

    Raises:
        SetcmasError: There is no run.
    """
    source = find_run(path)
    return source.stem.rstrip('_') or source.folder.resolve().name or 'run'
