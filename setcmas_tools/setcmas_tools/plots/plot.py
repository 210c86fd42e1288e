"""Plots of a run from its fleet.csv."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure
from tqdm import tqdm

from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.communication import draw_counts, draw_instants
from setcmas_tools.plots.disagreement import draw_disagreement
from setcmas_tools.plots.distances import draw_distances
from setcmas_tools.plots.formats import FORMATS, PALETTES
from setcmas_tools.plots.graph import MOST_ROBOTS, draw_graph
from setcmas_tools.plots.style import check_style, finish, plot_style, save
from setcmas_tools.plots.time_series import draw_heading, draw_positions, draw_velocities
from setcmas_tools.plots.trajectories import draw_trajectories
from setcmas_tools.records import communication as communication_record
from setcmas_tools.records import fleet_table
from setcmas_tools.records.communication import CommunicationRecord
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.description import RunDescription, describe
from setcmas_tools.run.files import fleet_csv, run_folder

Draw = Callable[[Figure, FleetTable], None]


def _plots(run: RunDescription, nb_robots: int) -> dict[str, Draw]:
    plots: dict[str, Draw] = {
        'trajectories': partial(draw_trajectories, run=run),
        'positions': draw_positions,
        'heading': draw_heading,
        'velocities': draw_velocities,
    }
    if nb_robots > 1:
        plots['distances'] = partial(draw_distances, references=run.references)
    return plots


def _communication_plots(record: CommunicationRecord | None, nb_robots: int) -> dict[str, Draw]:
    """Return the further plots of a run with a record of its communication."""
    plots: dict[str, Draw] = {}
    if record and record.is_event_triggered:
        plots['communication_instants'] = partial(draw_instants, record=record)
        plots['communication_counts'] = partial(draw_counts, record=record)
    if record and len(record.changes) and 1 < nb_robots <= MOST_ROBOTS:
        plots['graph'] = partial(draw_graph, record=record)
    if record and nb_robots > 1:
        plots['disagreement'] = draw_disagreement
    return plots


def plot(
    run: Path,
    output: Path | None = None,
    formats: Sequence[str] = ('png',),
    show: bool = False,
    progress: bool = True,
    palette: str = PALETTES[0],
    paper: str | None = None,
) -> list[Path]:
    """Plot trajectories, positions, headings, velocities and distances of a fleet.

    Of a run with a record of its communication also when robots sent their states and how often,
    the graph, and the disagreement.

    Args:
        run: The folder of a run, the folder of its CSV files, or a fleet.csv.
        output: Folder of the plots; by default `plots` in the folder of the run.
        formats: Any of `plot_formats.FORMATS`.
        show: Whether to open the plots in windows too, until the user closes them.
        progress: Whether to show a progress bar if there is a terminal.
        palette: One of `plot_formats.PALETTES`.
        paper: One of `plot_formats.PAPERS`, for fonts and sizes of a printed paper.

    Returns:
        The files, at least four; there are no distances with a single robot.

    Raises:
        SetcmasError: There is no fleet.csv or it is damaged, a choice is unknown, the plots
            cannot be written, or there is no screen to show them on.
    """
    for unknown in set(formats) - set(FORMATS):
        raise SetcmasError(f"format '{unknown}' is unknown; accepted are {', '.join(FORMATS)}")
    check_style(palette, paper)
    source = fleet_csv(run)
    table = fleet_table.read_csv(source)
    folder = output or run_folder(source) / 'plots'
    description = describe(source, table.robots)
    plots = _plots(description, len(table.robots))
    record = communication_record.read_csv(source.parent)
    plots |= _communication_plots(record, len(table.robots))
    with plot_style(palette, paper):
        figures = {name: _figure(show) for name in plots}
        hidden = None if progress else True  # None: hidden unless there is a terminal
        try:
            folder.mkdir(parents=True, exist_ok=True)
            paths = []
            for name, draw in tqdm(plots.items(), desc='plots', leave=False, disable=hidden):
                draw(figures[name], table)
                finish(figures[name], description.title)
                paths += _write(figures[name], folder / name, formats)
        except OSError as error:
            raise SetcmasError(
                f"plots cannot be written to '{folder}': {error.strerror}"
            ) from error
        if show:
            _show(folder)
    return paths


def _write(figure: Figure, path: Path, formats: Sequence[str]) -> list[Path]:
    paths = [path.with_name(f'{path.name}.{ending}') for ending in formats]
    for each in paths:
        save(figure, each)
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
