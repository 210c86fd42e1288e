"""Films of runs."""

from __future__ import annotations

import base64
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tqdm import tqdm

from setcmas_simu.errors import SetcmasError
from setcmas_tools.films import writers as film_writers
from setcmas_tools.films.frames import FilmFrames, from_first_command
from setcmas_tools.plots.looks.look import FilmLook, check_style
from setcmas_tools.plots.looks.style import plot_style
from setcmas_tools.records.fleet_grid import on_grid
from setcmas_tools.run.run import Run

_NAME = 'film'
_LOOK = FilmLook()


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


def film(run: Run, kind: str | None = None, **look: Any) -> Film:
    """Return a film of the fleet in the plane; `kind` as for `animate`, `look` as `FilmLook`."""
    with tempfile.TemporaryDirectory(prefix='setcmas-film-') as folder:
        path = animate(run, Path(folder), kind, FilmLook(**look), progress=False)
        return Film(path.read_bytes(), path.suffix.removeprefix('.'))


def animate(
    run: Run,
    folder: Path,
    kind: str | None = None,
    look: FilmLook = _LOOK,
    progress: bool = True,
) -> Path:
    """Write a film of the fleet in the plane, with trails, drawings, time and communications.

    Args:
        run: The run.
        folder: Where the film goes.
        kind: One of `formats.FILMS`; None for MP4 where ffmpeg is there, else GIF.
        look: How it looks.
        progress: Whether to show a progress bar if there is a terminal.

    Returns:
        The file.

    Raises:
        SetcmasError: A choice is unknown, ffmpeg is missing or fails, or the film cannot be
            written or is too long for a GIF.
    """
    kind = film_writers.best_kind(kind)
    check_style(look.palette, None)
    path = folder / f'{_NAME}.{kind}'
    rate = film_writers.rate_of(kind) / look.speed
    grid = on_grid(from_first_command(run.table), rate)
    trails = on_grid(from_first_command(run.table), rate * max(1, math.ceil(look.speed)))
    film_writers.check_length(kind, len(grid.t))
    hidden = None if progress else True  # None: hidden unless there is a terminal
    with plot_style(look.palette):
        frames = FilmFrames(grid, trails, run, look)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            film_writers.write(
                kind, path, tqdm(frames, desc='film', unit='frame', leave=False, disable=hidden)
            )
        except OSError as error:
            raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error
    return path
