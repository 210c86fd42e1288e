"""Film of a run: frames and file."""

from __future__ import annotations

import contextlib
import math
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.artist import Artist
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray
from tqdm import tqdm

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_tools.plots.plot_options import FILMS
from setcmas_tools.plots.reference_lines import draw_references
from setcmas_tools.plots.style import (
    as_written,
    data_url,
    legend,
    line_look,
    plot_style,
    robot_handles,
)
from setcmas_tools.plots.trajectories import (
    MOST_NUMBERS,
    DrawnPlane,
    draw_world,
    fit_plane,
)
from setcmas_tools.run.fleet_motion import SAME_TIME_S, FleetGrid, FleetTable, on_grid
from setcmas_tools.run.run import Run, symbols_of

_ROBOT_SIZE = 0.022  # share of the visible width
_LEAST_ROBOT_M = 0.07  # half a TurtleBot3
_NUMBER_POINTS = (7.0, 7.0)  # from a robot to its number
_JOINT = 2  # positions by which pieces of a trail overlap
_RATES_HZ = {'mp4': 25, 'gif': 10}
_MOST_GIF_FRAMES = 1200
_MP4 = ['-pix_fmt', 'yuv420p', '-movflags', '+faststart']  # for every player and browser


class FilmFrames:
    """Draws frame after frame.

    Trails stay on the canvas and grow by a piece per frame, and all static parts are drawn once,
    so that each frame takes equally long, even at the end of a long run.
    """

    def __init__(
        self, figure: Figure, grid: FleetGrid, trails: FleetGrid, run: Run, speed: float
    ) -> None:
        """Draw the static parts into an empty figure; call within `plot_style`.

        The film plays `speed` times as fast as real time. `grid` has the poses at the times of the
        frames, `trails` these and further ones between.
        """
        self._grid = grid
        self._speed = speed
        self._positions = np.stack([grid.x, grid.y], axis=2)
        self._trail_t = trails.t
        self._trail_positions = np.stack([trails.x, trails.y], axis=2)
        self.figure = figure
        self._canvas: Any = FigureCanvasAgg(figure)  # untyped in matplotlib
        self._axes = figure.add_subplot()
        self._drawn = DrawnPlane(self._axes, run)
        marks = draw_world(self._axes, run) + draw_references(self._axes, run, is_film=True)
        marks += self._drawn.handles
        fit_plane(self._axes, from_first_command(run.table))
        self._axes.set_title(as_written(run.title))
        legend(self._axes, [*robot_handles(grid.robots), *marks])
        self._add_moving_artists()
        self.figure.draw_without_rendering()
        width = np.ptp(self._axes.get_xlim())
        size = max(_LEAST_ROBOT_M, _ROBOT_SIZE * float(width))
        found = symbols_of(run)
        self._symbols = [size * found[robot] for robot in grid.robots]

    def __len__(self) -> int:
        return len(self._grid.t)

    def __iter__(self) -> Iterator[NDArray[np.uint8]]:
        self._canvas.draw()
        background = self._canvas.copy_from_bbox(self.figure.bbox)
        for k in range(len(self)):
            self._canvas.restore_region(background)
            self._draw_trails(k)
            background = self._canvas.copy_from_bbox(self.figure.bbox)
            self._draw_robots(k)
            yield np.asarray(self._canvas.buffer_rgba())

    def _add_moving_artists(self) -> None:
        nb_robots = len(self._grid.robots)
        looks = [line_look(robot, nb_robots) for robot in self._grid.robots]
        colours, widths = ([look[name] for look in looks] for name in ('color', 'linewidth'))
        edges = [look['linewidth'] + 1.2 if 'path_effects' in look else 0.0 for look in looks]
        self._edges = LineCollection([], colors='0.25', linewidths=edges, capstyle='butt')
        self._trails = LineCollection([], colors=colours, linewidths=widths, capstyle='round')
        edge: dict[str, Any] = {'edgecolors': '0.15', 'linewidths': 0.7}
        self._robots = PolyCollection([], facecolors=colours, **edge)
        self._clock = self._axes.text(
            1.02, 0.0, self._caption(self._grid.t[-1]),  # the longest text, for the layout
            transform=self._axes.transAxes, va='bottom', linespacing=1.5,
            fontsize=rcParams['legend.fontsize'],
        )  # fmt: skip
        for lines in (self._edges, self._trails, self._robots):
            self._axes.add_collection(lines, autolim=False)
        halo = [withStroke(linewidth=2.5, foreground='white')]
        self._numbers = [
            self._axes.annotate(
                str(robot), (0.0, 0.0), _NUMBER_POINTS, textcoords='offset points',
                fontsize=rcParams['legend.fontsize'], path_effects=halo, in_layout=False,
            )
            for robot in (self._grid.robots if nb_robots <= MOST_NUMBERS else [])
        ]  # fmt: skip
        self._above: list[Artist] = [self._robots, *self._numbers, self._clock]
        drawn = self._drawn.trails, self._drawn.markers
        for artist in (*drawn, self._edges, self._trails, *self._above):
            artist.set_animated(True)

    def _draw_trails(self, k: int) -> None:
        self._drawn.show(self._grid.t[k], since=self._grid.t[k - 1] if k else -np.inf)
        self._axes.draw_artist(self._drawn.trails)
        if k == 0:
            return
        between = self._grid.t[k - 1] - SAME_TIME_S, self._grid.t[k] + SAME_TIME_S
        begin, end = np.searchsorted(self._trail_t, between)
        self._edges.set_segments(list(self._trail_positions[:, begin:end]))
        self._trails.set_segments(list(self._trail_positions[:, max(0, begin - _JOINT) : end]))
        self._axes.draw_artist(self._edges)
        self._axes.draw_artist(self._trails)

    def _draw_robots(self, k: int) -> None:
        now, theta = self._grid.t[k], self._grid.theta[:, k]
        self._axes.draw_artist(self._drawn.markers)
        turns = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
        self._robots.set_verts([
            place + symbol @ turn
            for place, symbol, turn in zip(
                self._positions[:, k], self._symbols, np.moveaxis(turns, 2, 0), strict=True
            )
        ])  # fmt: skip
        for number, place in zip(self._numbers, self._positions[:, k], strict=False):
            number.xy = tuple(place)
            number.set_visible(bool(np.isfinite(place).all()))
        self._clock.set_text(self._caption(now))
        for artist in self._above:
            self._axes.draw_artist(artist)

    def _caption(self, now: float) -> str:
        lines = [f't = {now:.1f} s']
        if self._speed != 1.0:
            lines.append(f'{self._speed:g} times real time')
        return '\n'.join(lines)


def from_first_command(table: FleetTable) -> FleetTable:
    """Return the rows from the first command on; all rows if there are none."""
    running = table.t >= 0.0
    return table.rows(running) if running.any() else table


_NAME = 'film'


@dataclass(frozen=True, repr=False)
class Film:
    """A film to show in a notebook.

    Attributes:
        content: Content of the file.
        kind: 'mp4' or 'gif'.
    """

    content: bytes
    kind: str

    def __repr__(self) -> str:
        return f'Film({self.kind}, {len(self.content) / 1e6:.1f} MB)'

    def _repr_html_(self) -> str:
        if self.kind == 'gif':
            url = data_url('image/gif', self.content)
            return f'<img src="{url}" alt="video of the run">'
        url = data_url('video/mp4', self.content)
        return f'<video controls loop autoplay muted src="{url}"></video>'


def film(run: Run, kind: str | None = None, **look: Any) -> Film:
    """Return a film; arguments as for `animate`."""
    with tempfile.TemporaryDirectory(prefix='setcmas-film-') as folder:
        path = animate(run, Path(folder), kind, **look, progress=False)
        return Film(path.read_bytes(), path.suffix.removeprefix('.'))


def animate(
    run: Run,
    folder: Path,
    kind: str | None = None,
    speed: float = 1.0,
    size: tuple[int, int] = (640, 540),
    dpi: float = 100.0,
    progress: bool = True,
) -> Path:
    """Write a film of the fleet in the plane, with trails, drawings and the time.

    Args:
        run: The run.
        folder: Folder of the film.
        kind: One of `plot_options.FILMS`; None for MP4 if ffmpeg is installed, else GIF.
        speed: Playback speed in multiples of real time.
        size: Width and height in pixels; odd sizes are reduced by one, for MP4.
        dpi: Dots per inch; higher values enlarge text and lines.
        progress: Whether to show a progress bar in a terminal.

    Returns:
        The file.

    Raises:
        SetcmasError: An option is invalid, ffmpeg is missing or fails, or the film cannot be
            written or is too long for a GIF.
    """
    kind = _best_kind(kind)
    path = folder / f'{_NAME}.{kind}'
    rate = _RATES_HZ[kind] / speed
    table = from_first_command(run.table)
    grid, trails = on_grid(table, rate), on_grid(table, rate * max(1, math.ceil(speed)))
    if kind == 'gif' and len(grid.t) > _MOST_GIF_FRAMES:
        raise SetcmasError(
            f'a video of {len(grid.t) / _RATES_HZ[kind]:.0f} s is too long for a GIF (at most '
            f'{_MOST_GIF_FRAMES / _RATES_HZ[kind]:g} s): use --speed '
            f'{math.ceil(100 * speed * len(grid.t) / _MOST_GIF_FRAMES) / 100:g} or more, '
            'or write mp4'
        )
    with plot_style(), file_errors(f"'{path}' cannot be written"):
        path.parent.mkdir(parents=True, exist_ok=True)
        width, height = (2 * (side // 2) / dpi for side in size)
        figure = Figure((width, height), dpi)
        _write(kind, path, FilmFrames(figure, grid, trails, run, speed), progress)
    return path


def _ffmpeg() -> str | None:
    """Return the ffmpeg of this machine: that of imageio-ffmpeg, or one on the PATH."""
    with contextlib.suppress(ImportError, RuntimeError):
        from imageio_ffmpeg import get_ffmpeg_exe  # type: ignore[import-untyped,unused-ignore]

        return str(get_ffmpeg_exe())
    return shutil.which('ffmpeg')


def _best_kind(wanted: str | None) -> str:
    """Return the kind of film to write: MP4 by default if ffmpeg is installed, else GIF.

    Raises:
        SetcmasError: The kind is unknown, or ffmpeg is missing.
    """
    if wanted is None:
        return 'mp4' if _ffmpeg() else 'gif'
    if wanted not in FILMS:
        raise SetcmasError(f"unknown video '{wanted}'; must be {', '.join(FILMS)}")
    if wanted == 'mp4' and not _ffmpeg():
        raise SetcmasError(
            'mp4 needs ffmpeg, which is not installed; use apt-get install ffmpeg, '
            'pip install imageio-ffmpeg, or gif'
        )
    return wanted


class _Picture(Artist):
    """Pixels that cover a figure, shape (height, width, 4)."""

    pixels: NDArray[np.uint8]

    def draw(self, renderer: RendererBase) -> None:
        """Draw the pixels as they are."""
        renderer.draw_image(renderer.new_gc(), 0, 0, self.pixels[::-1])


def _write(kind: str, path: Path, frames: FilmFrames, progress: bool) -> None:
    """Write a film whole, or not at all.

    Raises:
        OSError: The file cannot be written.
        SetcmasError: ffmpeg fails.
    """
    hidden = None if progress else True  # None: hidden unless in a terminal
    rcParams['animation.ffmpeg_path'] = _ffmpeg() or 'ffmpeg'
    writer: AbstractMovieWriter = PillowWriter(_RATES_HZ[kind])
    if kind == 'mp4':
        writer = FFMpegWriter(_RATES_HZ[kind], 'h264', extra_args=_MP4)
    part = path.with_name(f'{path.stem}.part.{kind}')
    # The writers draw a figure whole: of these, each has a picture that is drawn in parts.
    screen = Figure(dpi=frames.figure.dpi)
    screen.set_size_inches(*frames.figure.get_size_inches().tolist())
    screen.set_layout_engine('none')
    screen.add_artist(shown := _Picture())
    try:
        with writer.saving(screen, str(part), screen.dpi):
            for picture in tqdm(frames, 'video', unit='frame', leave=False, disable=hidden):
                shown.pixels = picture
                writer.grab_frame()
        part.replace(path)
    except subprocess.CalledProcessError as error:
        if isinstance(error.__context__, KeyboardInterrupt):  # it reached ffmpeg, too
            raise error.__context__ from None
        reason = ' '.join(str(error.stderr).split())
        raise SetcmasError(f'ffmpeg cannot write the video: {reason}') from None
    finally:
        part.unlink(missing_ok=True)
