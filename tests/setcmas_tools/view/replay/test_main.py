"""The page of a run, in a real browser."""

import re
import shutil

import numpy as np
import pytest
from processes import SETCMAS

from setcmas_tools import Run, simulate

pytest.importorskip('viser')
needs_browser = pytest.mark.skipif(
    not (shutil.which('chromium') and shutil.which('chromedriver')),
    reason='chromium and chromium-driver are not installed',
)
TIME = '[data-floating-window]:has(.setcmas-time) .mantine-NumberInput-input'


def number(text):
    return float(text.replace('−', '-'))


def rows_of(browser):
    """Return what the panel tells of each robot: speed, x, y, heading in degrees."""
    js = "return [...document.querySelectorAll('.sc tr')].map(r => r.innerText)"
    found = {}
    for line in browser.execute_script(js)[1:]:
        robot, *cells = line.split('\t')
        found[int(robot)] = [number(cell) for cell in cells[:4]]
    return found


def at(run, t):
    """Return what fleet.csv tells of each robot at a time, rounded as on the page."""
    rows = run.table.rows(np.isclose(run.table.t, t))
    return {
        int(robot): [round(v, 2), round(x, 2), round(y, 2), round(np.degrees(theta))]
        for robot, v, x, y, theta in zip(
            rows.robot, rows.v, rows.x, rows.y, rows.theta, strict=True
        )
    }


@needs_browser
def test_scrubbed_in_a_browser(start, tmp_path):
    from browser import choose, close_notifications, open_browser, wait_for, wait_for_text
    from selenium.webdriver.common.keys import Keys

    run = Run.load(
        simulate('consensus', 3, 20.0, graph='path', event_triggered=True).save(tmp_path / 'run')
    )
    page = start(*SETCMAS, 'view', tmp_path / 'run', '--at', '5')
    page.wait_for_output('browser view: http')
    with open_browser(1366, 768) as browser:
        browser.get(re.search(r'http://\S+', page.output()).group())
        wait_for_text(browser, 't = 5.00 s of 20.0 s')
        close_notifications(browser)
        wait_for(lambda: rows_of(browser) == at(run, 5.0))
        browser.find_element('tag name', 'body').send_keys(Keys.ARROW_RIGHT)
        wait_for(lambda: rows_of(browser) == at(run, 5.1))
        slider = browser.find_element('css selector', TIME)
        slider.send_keys(Keys.CONTROL, 'a')
        slider.send_keys('12.3', Keys.ENTER)
        wait_for(lambda: rows_of(browser) == at(run, 12.3))
        cursor = "return getComputedStyle(document.querySelector('.u-over'), '::after').left"
        width = "return document.querySelector('.u-over').clientWidth"
        share = number(browser.execute_script(cursor)[:-2]) / browser.execute_script(width)
        assert share == pytest.approx(12.3 / 20, abs=0.01)

        chart = browser.find_element('css selector', '.u-over')
        chart.click()  # its middle
        wait_for(lambda: rows_of(browser) == at(run, 10.0))

        choose(browser, 'click one', 'robot 1')
        wait_for_text(browser, 'not heard')  # robot 3, on a path
        wait_for_text(browser, 't = 10.00 s')
        browser.find_element('tag name', 'body').send_keys(Keys.END)
        wait_for(lambda: rows_of(browser) == at(run, 20.0))
        browser.find_element('tag name', 'body').send_keys(Keys.HOME)
        wait_for(lambda: rows_of(browser) == at(run, 0.0))
        browser.find_element('tag name', 'body').send_keys(' ')
        wait_for(lambda: rows_of(browser) != at(run, 0.0))
