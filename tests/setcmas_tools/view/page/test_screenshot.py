import io
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

pytest.importorskip('viser')
from setcmas_tools.view.page.controls import take_screenshot


class Browser:
    """What viser knows of a browser, whose picture is one translucent red pixel or an error."""

    camera = SimpleNamespace(image_height=1, image_width=1)

    def __init__(self, error=None):
        self._error = error
        self.saved = []
        self.told = []

    def get_render(self, *_, **__):
        if self._error:
            raise self._error
        return np.array([[[255, 0, 0, 128]]], np.uint8)

    def send_file_download(self, name, content, **_):
        self.saved.append((name, content))

    def add_notification(self, title, _body):
        self.told.append(title)


def test_a_browser_saves_what_it_shows():
    browser = Browser()
    take_screenshot(browser)

    ((name, content),) = browser.saved
    assert name.endswith('.png')
    picture = Image.open(io.BytesIO(content))
    assert (picture.format, picture.mode, picture.getpixel((0, 0))) == (
        'PNG',
        'RGB',
        (255, 127, 127),
    )


def test_a_browser_that_is_closed_meanwhile_leaves_no_traceback():
    browser = Browser(RuntimeError('the client disconnected before returning a frame'))
    take_screenshot(browser)

    assert not browser.saved


def test_a_browser_that_is_too_slow_is_told():
    browser = Browser(TimeoutError())
    take_screenshot(browser)

    assert browser.told == ['No screenshot']
    assert not browser.saved
