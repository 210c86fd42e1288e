"""Writers of films: GIF by Pillow, MP4 by ffmpeg."""

from __future__ import annotations

import itertools
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from setcmas_simu.errors import SetcmasError
from setcmas_tools.plots.plot_settings import FILMS

GIF_RATE_HZ = 10.0
MP4_RATE_HZ = 25.0
_GIF_COLOURS = 128
_NEAR = 12  # of 255
_MOST_GIF_FRAMES = 1200
_FFMPEG = 'ffmpeg'


def best_kind(wanted: str | None) -> str:
    """Return the kind of film to write.

    Args:
        wanted: One of `look.FILMS`; None for MP4 if ffmpeg is installed, else GIF.

    Raises:
        SetcmasError: The kind is unknown, or ffmpeg is missing.
    """
    has_ffmpeg = shutil.which(_FFMPEG) is not None
    if wanted is None:
        return 'mp4' if has_ffmpeg else 'gif'
    if wanted not in FILMS:
        raise SetcmasError(f"unknown video '{wanted}'; must be {', '.join(FILMS)}")
    if wanted == 'mp4' and not has_ffmpeg:
        raise SetcmasError(
            'mp4 needs ffmpeg, which is not installed; use apt-get install ffmpeg, or gif'
        )
    return wanted


def rate_of(kind: str) -> float:
    """Return the frames per second of a kind of film."""
    return MP4_RATE_HZ if kind == 'mp4' else GIF_RATE_HZ


def check_length(kind: str, nb_frames: int) -> None:
    """Check that a film is not too long for its kind.

    Raises:
        SetcmasError: It is too long.
    """
    if kind == 'gif' and nb_frames > _MOST_GIF_FRAMES:
        seconds = nb_frames / GIF_RATE_HZ
        raise SetcmasError(
            f'a video of {seconds:.0f} s is too long for a GIF (at most '
            f'{_MOST_GIF_FRAMES / GIF_RATE_HZ:g} s): use --speed '
            f'{seconds * GIF_RATE_HZ / _MOST_GIF_FRAMES:.0f} or more, or write mp4'
        )


def write(kind: str, path: Path, frames: Iterable[Image.Image]) -> None:
    """Write a film; remove an unfinished file.

    Args:
        kind: One of `look.FILMS`.
        path: The file.
        frames: Images of the same even width and height, mode RGB.

    Raises:
        OSError: The file cannot be written.
        SetcmasError: ffmpeg fails.
    """
    part = path.with_name(f'{path.name}.part')
    try:
        (_write_mp4 if kind == 'mp4' else _write_gif)(part, iter(frames))
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _write_gif(path: Path, frames: Iterator[Image.Image]) -> None:
    # One palette for all frames: unchanged pixels are not written again and do not flicker.
    first = next(frames)
    palette = _palette(first)
    flat = (
        frame.quantize(palette=palette, dither=Image.Dither.NONE)
        for frame in itertools.chain([first], frames)
    )
    with path.open('wb') as file:
        next(flat).save(
            file, 'GIF', save_all=True, append_images=flat, duration=1000 / GIF_RATE_HZ, loop=0,
            optimize=False,
        )  # fmt: skip


def _palette(image: Image.Image) -> Image.Image:
    """Return a palette of the most frequent colours, so that robots keep their colours.

    Skips colours close to one in the palette, since Pillow maps a pixel to any close colour.
    """
    found, counts = np.unique(np.asarray(image).reshape(-1, 3), axis=0, return_counts=True)
    colours = found[np.argsort(-counts, kind='stable')].astype(int)
    chosen: list[int] = []
    while len(colours) and len(chosen) < 3 * _GIF_COLOURS:
        chosen.extend(colours[0].tolist())
        colours = colours[np.abs(colours - colours[0]).max(axis=1) >= _NEAR]
    palette = Image.new('P', (1, 1))
    palette.putpalette(chosen)
    return palette


def _write_mp4(path: Path, frames: Iterator[Image.Image]) -> None:
    first = next(frames)
    command = [
        _FFMPEG, '-loglevel', 'error', '-y',
        '-f', 'rawvideo', '-pix_fmt', 'rgb24', '-s', f'{first.width}x{first.height}',
        '-r', f'{MP4_RATE_HZ:g}', '-i', '-',
        '-pix_fmt', 'yuv420p',  # supported by every player and browser
        '-movflags', '+faststart', '-f', 'mp4', str(path),
    ]  # fmt: skip
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as ffmpeg:
        assert ffmpeg.stdin is not None
        assert ffmpeg.stderr is not None
        try:
            for frame in itertools.chain([first], frames):
                ffmpeg.stdin.write(frame.tobytes())
            ffmpeg.stdin.close()
        except BrokenPipeError:
            pass  # its error output has the reason
        except BaseException:
            ffmpeg.kill()
            raise
        text = ffmpeg.stderr.read().decode(errors='replace')
    if ffmpeg.returncode:
        raise SetcmasError(f'ffmpeg cannot write the video: {" ".join(text.split())}')
