import re
import subprocess

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image
from runs import animate

from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.palettes import plot_colour
from setcmas_tools.plots import film


@pytest.fixture
def no_ffmpeg(monkeypatch):
    monkeypatch.setattr(film, '_ffmpeg', lambda: None)


def frame(opened, number):
    opened.seek(number)
    return np.asarray(opened.convert('RGB')).astype(int)


def count(picture, colour):
    """Return the number of pixels of a colour (from 0 to 255) inside the axes."""
    inside = picture[:, : int(0.7 * picture.shape[1])]
    return int((np.abs(inside - colour).max(axis=2) < 20).sum())


def test_without_ffmpeg_a_gif_shows_robots_that_leave_trails(run, no_ffmpeg, tmp_path):
    path = animate(run(2), tmp_path / 'elsewhere', speed=4.0, size=(501, 400), dpi=80)

    assert path == tmp_path / 'elsewhere' / 'film.gif'
    with Image.open(path) as opened:
        assert opened.n_frames == 28  # from the first command on
        assert opened.size == (500, 400)
        assert (opened.info['duration'], opened.info['loop']) == (100, 0)
        first, last = frame(opened, 0), frame(opened, 27)
        assert tuple(first[0, 0]) == (255, 255, 255)
        for robot in (1, 2):
            colour = np.multiply(255, plot_colour(robot, 2))
            assert 0 < count(first, colour) < count(last, colour)


@pytest.mark.nightly
def test_an_mp4_where_there_is_ffmpeg(run):
    path = animate(run(2))

    assert path.name == 'film.mp4'
    told = subprocess.run(
        [imageio_ffmpeg.get_ffmpeg_exe(), '-i', str(path), '-f', 'null', '-'],
        capture_output=True,
        text=True,
        check=True,
    ).stderr
    assert re.search(r'Video: h264.* yuv420p.* 25 fps', told)
    assert re.findall(r'frame= *(\d+)', told)[-1] == '273'  # 10.9 s and the last pose


def test_mistakes_get_one_line(run, no_ffmpeg):
    folder = run(1)
    with pytest.raises(SetcmasError, match="unknown video 'avi'; must be mp4, gif"):
        animate(folder, kind='avi')
    with pytest.raises(SetcmasError, match='mp4 needs ffmpeg, which is not installed'):
        animate(folder, kind='mp4')
    with pytest.raises(SetcmasError, match=r'too long for a GIF.*--speed 0.1 or more'):
        animate(folder, kind='gif', speed=0.0125)


@pytest.mark.parametrize('kind', ['gif', 'mp4'])
def test_an_unfinished_film_is_removed(run, kind, monkeypatch):
    folder = run(1)
    shown = film.FilmFrames.show

    def interrupted(frames, k):
        if k == 3:
            raise KeyboardInterrupt
        shown(frames, k)

    monkeypatch.setattr(film.FilmFrames, 'show', interrupted)
    with pytest.raises(KeyboardInterrupt):
        animate(folder, kind=kind)

    assert not list(folder.glob('**/film*'))


def test_complaints_of_ffmpeg_are_reported(run, monkeypatch):
    monkeypatch.setattr(film, '_MP4', ['-pix_fmt', 'nothing'])

    with pytest.raises(SetcmasError, match=r'ffmpeg cannot write the video: .*nothing'):
        animate(run(1), kind='mp4')
