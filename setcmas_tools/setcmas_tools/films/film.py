"""A film of a run from its fleet.csv."""

from __future__ import annotations

from pathlib import Path

from tqdm import tqdm

from setcmas_simu.errors import SetcmasError
from setcmas_tools.films import writers as film_writers
from setcmas_tools.films.frames import FilmFrames
from setcmas_tools.plots.formats import PALETTES
from setcmas_tools.plots.style import check_style, plot_style
from setcmas_tools.records import communication as communication_record
from setcmas_tools.records import fleet_table
from setcmas_tools.records.fleet_grid import on_grid
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.description import describe
from setcmas_tools.run.files import fleet_csv, run_folder

_NAME = 'film'


def animate(
    run: Path,
    output: Path | None = None,
    kind: str | None = None,
    speed: float = 1.0,
    progress: bool = True,
    palette: str = PALETTES[0],
) -> Path:
    """Write a film of the fleet in the plane, with trails, time and communications.

    Args:
        run: The folder of a run, the folder of its CSV files, or a fleet.csv.
        output: Folder of the film; by default `plots` in the folder of the run.
        kind: One of `plot_formats.FILMS`; None for MP4 where ffmpeg is there, else GIF.
        speed: How many times faster than the robots the film is.
        progress: Whether to show a progress bar if there is a terminal.
        palette: One of `plot_formats.PALETTES`.

    Returns:
        The file.

    Raises:
        SetcmasError: There is no fleet.csv or it is damaged, a choice is unknown, ffmpeg is
            missing or fails, or the film cannot be written or is too long for a GIF.
    """
    kind = film_writers.best_kind(kind)
    check_style(palette, None)
    source = fleet_csv(run)
    table = _from_first_command(fleet_table.read_csv(source))
    path = (output or run_folder(source) / 'plots') / f'{_NAME}.{kind}'
    grid = on_grid(table, film_writers.rate_of(kind) / speed)
    film_writers.check_length(kind, len(grid.t))
    record = communication_record.read_csv(source.parent)
    triggers = record.trigger_times if record else {}
    hidden = None if progress else True  # None: hidden unless there is a terminal
    with plot_style(palette):
        frames = FilmFrames(grid, table, describe(source, grid.robots), triggers, speed)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            film_writers.write(
                kind, path, tqdm(frames, desc='film', unit='frame', leave=False, disable=hidden)
            )
        except OSError as error:
            raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error
    return path


def _from_first_command(table: FleetTable) -> FleetTable:
    """Return the rows from the first command on; all of them if there are none after it."""
    running = table.t >= 0.0
    return table.rows(running) if running.any() else table
