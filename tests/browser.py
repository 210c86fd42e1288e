"""A real browser for tests of pages: headless Chromium from the system."""

import contextlib
import shutil
import time
from collections.abc import Iterator

from processes import TIMEOUT_S
from selenium import webdriver

_ARGUMENTS = (
    '--headless=new',
    '--no-sandbox',  # it runs as root in containers
    '--disable-dev-shm-usage',
    '--disable-gpu',  # there is none, and imitating one costs twice the time of drawing without
    '--hide-scrollbars',
    # No page of setcmas needs a network.
    '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost, EXCLUDE 127.0.0.1',
    # Chromium draws no page that it believes hidden.
    '--disable-backgrounding-occluded-windows',
    '--disable-renderer-backgrounding',
    '--disable-background-timer-throttling',
)

# A picture takes some ms of a core, and tests look at the page seldom: two a second are enough.
_FEW_PICTURES = """
const request = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = callback => setTimeout(() => request(callback), 500);
"""


@contextlib.contextmanager
def open_browser(
    width: int, height: int, every_picture: bool = False
) -> Iterator[webdriver.Chrome]:
    """Open a browser whose window has a size in pixels; it draws seldom, or every picture."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which('chromium') or ''
    for argument in (*_ARGUMENTS, f'--window-size={width},{height}'):
        options.add_argument(argument)
    service = webdriver.ChromeService(shutil.which('chromedriver'))
    browser = webdriver.Chrome(options=options, service=service)
    try:
        browser.set_window_size(width, height)
        if not every_picture:
            _draw_seldom(browser)
        yield browser
    finally:
        browser.quit()


def open_page(browser, address: str) -> None:
    """Open a page, and wait until it is loaded: for a file, `get` sometimes returns before."""
    browser.get(address)
    wait_for(lambda: browser.execute_script('return document.readyState') == 'complete')


def open_window(browser) -> None:
    """Open a further window, and look at it."""
    browser.switch_to.new_window('window')
    _draw_seldom(browser)


def _draw_seldom(browser) -> None:
    source = {'source': _FEW_PICTURES}
    browser.execute_cdp_cmd('Page.addScriptToEvaluateOnNewDocument', source)


def wait_for(condition, timeout: float = TIMEOUT_S) -> None:
    """Wait until a condition holds; fails if it never does."""
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, 'the condition did not come true in time'
        time.sleep(0.1)
