"""Film of a run: frames and file."""

from __future__ import annotations

import contextlib
import math
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.artist import Artist
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
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
from setcmas_tools.run.fleet_motion import FleetGrid, FleetTable, on_grid
from setcmas_tools.run.run import Run, symbols_of

_ROBOT_SIZE = 0.022  # share of the visible width
_LEAST_ROBOT_M = 0.07  # half a TurtleBot3
_NUMBER_POINTS = (7.0, 7.0)  # from a robot to its number
_RATES_HZ = {'mp4': 25, 'gif': 10}
_MOST_GIF_FRAMES = 1200
_MP4 = ['-pix_fmt', 'yuv420p', '-movflags', '+faststart']  # for every player and browser


class _Picture(Artist):
    """Pixels that cover a figure, shape (height, width, 4)."""

    def __init__(self, pixels: NDArray[np.uint8]) -> None:
        """Lie behind all axes."""
        super().__init__()
        self._pixels = pixels[::-1]
        self.set_zorder(-1)

    def draw(self, renderer: RendererBase) -> None:
        """Draw the pixels as they are, which `figimage` would resample."""
        renderer.draw_image(renderer.new_gc(), 0, 0, self._pixels)


class FilmFrames:
    """The frames of a film, in its figure one after another.

    All static parts are drawn once, into a picture behind the moving ones.
    """

    def __init__(self, figure: Figure, grid: FleetGrid, run: Run, speed: float) -> None:
        """Draw the static parts into an empty figure; call within `plot_style`.

        The film plays `speed` times as fast as real time; `grid` has the poses.
        """
        self._grid, self._speed = grid, speed
        self.figure = figure
        self._axes = figure.add_subplot()
        self._drawn = DrawnPlane(self._axes, run)
        marks = draw_world(self._axes, run) + draw_references(self._axes, run, is_film=True)
        fit_plane(self._axes, from_first_command(run.table))
        self._axes.set_title(as_written(run.title))
        legend(self._axes, [*robot_handles(grid.robots), *marks, *self._drawn.handles])
        self._add_moving_artists()
        size = max(_LEAST_ROBOT_M, _ROBOT_SIZE * float(np.ptp(self._axes.get_xlim())))
        outlines = symbols_of(run)
        self._outlines = [size * outlines[robot] for robot in grid.robots]

    def _add_moving_artists(self) -> None:
        robots = self._grid.robots
        looks = [line_look(robot, len(robots)) for robot in robots]
        self._trails = [self._axes.plot([], [], **look)[0] for look in looks]
        self._robots = PolyCollection(
            [], facecolors=[look['color'] for look in looks], edgecolors='0.15', linewidths=0.7,
            zorder=4,
        )  # fmt: skip
        self._axes.add_collection(self._robots, autolim=False)
        self._clock = self._axes.text(
            1.02, 0.0, self._caption(self._grid.t[-1]),  # the longest text, for the layout
            transform=self._axes.transAxes, va='bottom', linespacing=1.5,
            fontsize=rcParams['legend.fontsize'],
        )  # fmt: skip
        halo = [withStroke(linewidth=2.5, foreground='white')]
        self._numbers = [
            self._axes.annotate(
                str(robot), (0.0, 0.0), _NUMBER_POINTS, textcoords='offset points', zorder=5,
                fontsize=rcParams['legend.fontsize'], path_effects=halo, in_layout=False,
            )
            for robot in (robots if len(robots) <= MOST_NUMBERS else [])
        ]  # fmt: skip
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine('none')
        moving = [*self._trails, self._robots, self._clock, *self._numbers]
        moving += [self._drawn.trails, self._drawn.markers]
        for artist in moving:
            artist.set_visible(False)
        canvas: Any = FigureCanvasAgg(self.figure)  # untyped in matplotlib
        canvas.draw()
        self.figure.add_artist(_Picture(np.array(canvas.buffer_rgba())))
        for artist in self._axes.get_children():
            artist.set_visible(artist in moving)

    def show(self, k: int) -> None:
        """Show sample k of the poses."""
        grid, now, theta = self._grid, self._grid.t[k], self._grid.theta[:, k]
        self._drawn.show(now)
        for trail, x, y in zip(self._trails, grid.x, grid.y, strict=True):
            trail.set_data(x[: k + 1], y[: k + 1])
        turns = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
        places = np.column_stack([grid.x[:, k], grid.y[:, k]])
        self._robots.set_verts([
            place + outline @ turn
            for place, outline, turn in zip(
                places, self._outlines, np.moveaxis(turns, 2, 0), strict=True
            )
        ])  # fmt: skip
        for number, place in zip(self._numbers, places, strict=False):
            number.xy = tuple(place)
            number.set_visible(bool(np.isfinite(place).all()))
        self._clock.set_text(self._caption(now))

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
    step = max(1, math.ceil(speed))  # trails of fast films have points between frames
    grid = on_grid(from_first_command(run.table), step * _RATES_HZ[kind] / speed)
    shown = range(0, len(grid.t), step)
    if kind == 'gif' and len(shown) > _MOST_GIF_FRAMES:
        raise SetcmasError(
            f'a video of {len(shown) / _RATES_HZ[kind]:.0f} s is too long for a GIF (at most '
            f'{_MOST_GIF_FRAMES / _RATES_HZ[kind]:g} s): use --speed '
            f'{math.ceil(100 * speed * len(shown) / _MOST_GIF_FRAMES) / 100:g} or more, '
            'or write mp4'
        )
    with plot_style(), file_errors(f"'{path}' cannot be written"):
        path.parent.mkdir(parents=True, exist_ok=True)
        width, height = (2 * (side // 2) / dpi for side in size)
        figure = Figure((width, height), dpi)
        _write(kind, path, FilmFrames(figure, grid, run, speed), shown, progress)
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


def _write(
    kind: str, path: Path, frames: FilmFrames, shown: Sequence[int], progress: bool
) -> None:
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
    try:
        with writer.saving(frames.figure, str(part), frames.figure.dpi):
            for k in tqdm(shown, 'video', unit='frame', leave=False, disable=hidden):
                frames.show(k)
                writer.grab_frame()
        part.replace(path)
    except subprocess.CalledProcessError as error:
        if isinstance(error.__context__, KeyboardInterrupt):  # it reached ffmpeg, too
            raise error.__context__ from None
        reason = ' '.join(str(error.stderr).split())
        raise SetcmasError(f'ffmpeg cannot write the video: {reason}') from None
    finally:
        part.unlink(missing_ok=True)
