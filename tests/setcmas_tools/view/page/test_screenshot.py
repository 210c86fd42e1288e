import io
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

pytest.importorskip('viser')
from setcmas_tools.view.page.screenshot import take_screenshot


class Browser:
    """What viser knows of a browser, whose picture is a translucent red bar or an error."""

    camera = SimpleNamespace(image_height=50, image_width=80)

    def __init__(self, error=None):
        self._error = error
        self.saved = []
        self.told = []

    def get_render(self, *_, **__):
        if self._error:
            raise self._error
        pixels = np.zeros((50, 80, 4), np.uint8)
        pixels[20:30, 10:70] = 255, 0, 0, 128
        return pixels

    def send_file_download(self, name, content, **_):
        self.saved.append((name, content))

    def add_notification(self, title, _body):
        self.told.append(title)


def test_a_browser_saves_what_it_shows():
    browser = Browser()
    take_screenshot(browser, 'consensus')

    ((name, content),) = browser.saved
    assert name.endswith('.png')
    picture = Image.open(io.BytesIO(content))
    bar = np.all(np.asarray(picture) == (255, 127, 127), axis=-1)
    above = np.asarray(picture)[: np.flatnonzero(bar.any(axis=1))[0]]
    assert (picture.format, picture.mode) == ('PNG', 'RGB')
    assert bar.sum() == 10 * 60
    assert bar.any(axis=0).mean() > 0.7  # nothing of what is empty around it
    assert (above.max(axis=-1) < 60).any()  # the title


def test_a_browser_that_is_closed_meanwhile_leaves_no_traceback():
    browser = Browser(RuntimeError('the client disconnected before returning a frame'))
    take_screenshot(browser, 'consensus')

    assert not browser.saved


def test_a_browser_that_is_too_slow_is_told():
    browser = Browser(TimeoutError())
    take_screenshot(browser, 'consensus')

    assert browser.told == ['No screenshot']
    assert not browser.saved
