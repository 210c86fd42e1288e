"""Plots of a run from its fleet.csv."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from tqdm import tqdm

from setcmas_simu.errors import SetcmasError
from setcmas_tools import fleet_table
from setcmas_tools.fleet_table import FleetTable
from setcmas_tools.plot_distances import draw_distances
from setcmas_tools.plot_formats import FORMATS
from setcmas_tools.plot_style import plot_style, save
from setcmas_tools.plot_time_series import draw_heading, draw_positions, draw_velocities
from setcmas_tools.plot_trajectories import draw_trajectories
from setcmas_tools.run_files import fleet_csv, run_folder

Draw = Callable[[Figure, FleetTable], None]

_PLOTS: dict[str, Draw] = {
    'trajectories': draw_trajectories,
    'positions': draw_positions,
    'heading': draw_heading,
    'velocities': draw_velocities,
    'distances': draw_distances,
}


def plot(
    run: Path,
    output: Path | None = None,
    formats: Sequence[str] = ('png',),
    show: bool = False,
    progress: bool = True,
) -> list[Path]:
    """Plot trajectories, positions, headings, velocities and distances of a fleet.

    Args:
        run: The folder of a run, the folder of its CSV files, or a fleet.csv.
        output: Folder of the plots; by default `plots` in the folder of the run.
        formats: Any of `plot_formats.FORMATS`.
        show: Whether to open the plots in windows too, until the user closes them.
        progress: Whether to show a progress bar if there is a terminal.

    Returns:
        The files, at least four; there are no distances with a single robot.

    Raises:
        SetcmasError: There is no fleet.csv or it is damaged, a format is unknown, the plots
            cannot be written, or there is no screen to show them on.
    """
    for unknown in set(formats) - set(FORMATS):
        raise SetcmasError(f"format '{unknown}' is unknown; accepted are {', '.join(FORMATS)}")
    source = fleet_csv(run)
    table = fleet_table.read_csv(source)
    folder = output or run_folder(source) / 'plots'
    names = [name for name in _PLOTS if name != 'distances' or len(table.robots) > 1]
    with plot_style():
        figures = {name: _figure(show) for name in names}
        try:
            paths = _write(figures, table, folder, formats, progress)
        except OSError as error:
            raise SetcmasError(
                f"plots cannot be written to '{folder}': {error.strerror}"
            ) from error
        if show:
            _show(folder)
    return paths


def _write(
    figures: dict[str, Figure],
    table: FleetTable,
    folder: Path,
    formats: Sequence[str],
    progress: bool,
) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    hidden = None if progress else True  # None: hidden unless there is a terminal
    for name, figure in tqdm(figures.items(), desc='plots', leave=False, disable=hidden):
        _PLOTS[name](figure, table)
        for ending in formats:
            paths.append(folder / f'{name}.{ending}')
            save(figure, paths[-1])
    return paths


def _figure(show: bool) -> Figure:
    if not show:
        return Figure()
    from matplotlib import pyplot  # only windows need it; it is what asks for a screen

    return pyplot.figure()


def _show(folder: Path) -> None:
    from matplotlib import pyplot

    if pyplot.get_backend().lower() == 'agg':
        raise SetcmasError(f"there is no screen to show plots on; they are in '{folder}'")
    pyplot.show()
