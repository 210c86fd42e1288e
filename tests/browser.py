"""A real browser for tests of the browser view: headless Chromium from the system."""

import contextlib
import shutil
import time
from collections.abc import Iterator

from processes import TIMEOUT_S
from selenium import webdriver
from selenium.webdriver.common.by import By

_ARGUMENTS = (
    '--headless=new',
    '--no-sandbox',  # it runs as root in containers
    '--disable-dev-shm-usage',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    '--hide-scrollbars',
    # viser knows a page once it has drawn; Chromium draws none that it believes hidden.
    '--disable-backgrounding-occluded-windows',
    '--disable-renderer-backgrounding',
    '--disable-background-timer-throttling',
)

# Without a graphics card a picture takes a core for a fifth of a second: two a second are enough.
_FEW_PICTURES = """
const request = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = callback => setTimeout(() => request(callback), 500);
"""


@contextlib.contextmanager
def open_browser(width: int, height: int) -> Iterator[webdriver.Chrome]:
    """Open a browser whose window has a size in pixels."""
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which('chromium') or ''
    for argument in (*_ARGUMENTS, f'--window-size={width},{height}'):
        options.add_argument(argument)
    service = webdriver.ChromeService(shutil.which('chromedriver'))
    browser = webdriver.Chrome(options=options, service=service)
    try:
        browser.set_window_size(width, height)
        _draw_seldom(browser)
        yield browser
    finally:
        browser.quit()


def open_window(browser) -> None:
    """Open a further window, and look at it."""
    browser.switch_to.new_window('window')
    _draw_seldom(browser)


def _draw_seldom(browser) -> None:
    source = {'source': _FEW_PICTURES}
    browser.execute_cdp_cmd('Page.addScriptToEvaluateOnNewDocument', source)


def text_of(browser) -> str:
    """Return what can be read on the page."""
    return browser.find_element(By.TAG_NAME, 'body').text


def wait_for(condition, timeout: float = TIMEOUT_S) -> None:
    """Wait until a condition holds; fails if it never does."""
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, 'the condition did not come true in time'
        time.sleep(0.1)


def wait_for_text(browser, text: str, timeout: float = TIMEOUT_S) -> None:
    """Wait until a text can be read on the page."""
    deadline = time.monotonic() + timeout
    while text not in text_of(browser):
        assert time.monotonic() < deadline, f'{text!r} is not on the page:\n{text_of(browser)}'
        time.sleep(0.1)


def buttons(browser) -> dict:
    """Return the panel's buttons by what is written on them."""
    found = browser.find_elements(By.TAG_NAME, 'button')
    return {button.text: button for button in found if button.text}


def close_notifications(browser) -> None:
    """Close what covers the picture, such as the remark that there is no graphics card."""
    for button in browser.find_elements(By.CSS_SELECTOR, '.mantine-Notification-closeButton'):
        button.click()
    wait_for(
        lambda: not browser.find_elements(By.CSS_SELECTOR, '.mantine-Notification-closeButton')
    )


def choose(browser, chosen: str, option: str) -> None:
    """Choose an option from the list in which another one is chosen now."""
    browser.find_element(By.CSS_SELECTOR, f'input[value="{chosen}"]').click()

    def found() -> list:
        options = browser.find_elements(By.CSS_SELECTOR, '[role=option]')
        return [one for one in options if one.text == option]

    wait_for(found)
    found()[0].click()
