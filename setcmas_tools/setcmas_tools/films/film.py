"""Films of runs."""

from __future__ import annotations

import base64
import tempfile
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from setcmas_simu.errors import SetcmasError
from setcmas_tools.films import writers as film_writers
from setcmas_tools.films.frames import FilmFrames, from_first_command
from setcmas_tools.plots.looks.formats import PALETTES
from setcmas_tools.plots.looks.look import check_style
from setcmas_tools.plots.looks.style import plot_style
from setcmas_tools.records.fleet_grid import on_grid
from setcmas_tools.run.run import Run

_NAME = 'film'


@dataclass(frozen=True, repr=False)
class Film:
    """A film that a notebook shows.

    Attributes:
        content: The bytes of its file.
        kind: 'mp4' or 'gif'.
    """

    content: bytes
    kind: str

    def __repr__(self) -> str:
        """Return one line."""
        return f'Film({self.kind}, {len(self.content) / 1e6:.1f} MB)'

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.content).decode('ascii')
        if self.kind == 'gif':
            return f'<img src="data:image/gif;base64,{data}" alt="film of the run">'
        return f'<video controls loop autoplay muted src="data:video/mp4;base64,{data}"></video>'


def film(
    run: Run, kind: str | None = None, speed: float = 1.0, palette: str = PALETTES[0]
) -> Film:
    """Return a film of the fleet in the plane; arguments as for `animate`."""
    with tempfile.TemporaryDirectory(prefix='setcmas-film-') as folder:
        path = animate(run, Path(folder), kind, speed, progress=False, palette=palette)
        return Film(path.read_bytes(), path.suffix.removeprefix('.'))


def animate(
    run: Run,
    folder: Path,
    kind: str | None = None,
    speed: float = 1.0,
    progress: bool = True,
    palette: str = PALETTES[0],
) -> Path:
    """Write a film of the fleet in the plane, with trails, time and communications.

    Args:
        run: The run.
        folder: Where the film goes.
        kind: One of `formats.FILMS`; None for MP4 where ffmpeg is there, else GIF.
        speed: How many times faster than the robots the film is.
        progress: Whether to show a progress bar if there is a terminal.
        palette: One of `formats.PALETTES`.

    Returns:
        The file.

    Raises:
        SetcmasError: A choice is unknown, ffmpeg is missing or fails, or the film cannot be
            written or is too long for a GIF.
    """
    kind = film_writers.best_kind(kind)
    check_style(palette, None)
    path = folder / f'{_NAME}.{kind}'
    grid = on_grid(from_first_command(run.table), film_writers.rate_of(kind) / speed)
    film_writers.check_length(kind, len(grid.t))
    hidden = None if progress else True  # None: hidden unless there is a terminal
    with plot_style(palette):
        frames = FilmFrames(grid, run, speed)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            film_writers.write(
                kind, path, tqdm(frames, desc='film', unit='frame', leave=False, disable=hidden)
            )
        except OSError as error:
            raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error
    return path
