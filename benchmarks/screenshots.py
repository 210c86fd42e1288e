"""Takes pictures of the page in its three uses, at three sizes, and of its print; to be looked at.

Needs chromium and chromium-driver, and pdftoppm for the print:

    python benchmarks/screenshots.py FOLDER
"""

from __future__ import annotations

import argparse
import base64
import contextlib
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))

from browser import open_browser, wait_for
from selenium import webdriver

from setcmas_tools import simulate

SETCMAS = str(Path(sys.executable).parent / 'setcmas')
SIZES = {'phone': (390, 844), 'laptop': (1366, 768), 'projector': (1920, 1080)}
A4_IN = {'paperWidth': 8.27, 'paperHeight': 11.69}
ENVIRONMENT = {
    **os.environ,
    'CI': '1',  # no browser of its own
    'ROS_DOMAIN_ID': str(1 + os.getpid() % 100),
    'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
}


def shoot(browser: webdriver.Chrome, folder: Path, name: str) -> None:
    """Select the third robot, and take a picture at each size."""
    browser.find_elements('css selector', '#robots button')[2].click()
    for size, (width, height) in SIZES.items():
        metrics = {'width': width, 'height': height, 'deviceScaleFactor': 1}
        metrics['mobile'] = size == 'phone'
        browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', metrics)
        time.sleep(1.5)
        browser.save_screenshot(str(folder / f'{name}_{size}.png'))
    browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})


@contextlib.contextmanager
def started(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [SETCMAS, *arguments], stdout=subprocess.PIPE, text=True, env=ENVIRONMENT
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()


def address(process: subprocess.Popen[str]) -> str:
    assert process.stdout
    return next(found[0] for line in process.stdout if (found := re.search(r'http://\S+', line)))


def handed_in(browser: webdriver.Chrome, folder: Path) -> None:
    """Compare two runs on a page, and print it."""
    runs = [folder / 'run', folder / 'slower']
    for path, vnom in zip(runs, (0.5, 0.3), strict=True):
        simulate('consensus', 8, 40.0, graph='ring', event_triggered=True, vnom=vnom).save(path)
    page = folder / 'run.html'
    subprocess.run([SETCMAS, 'report', *runs, '-o', page, '--overwrite'], check=True)
    browser.get(f'{page.as_uri()}#t=9')
    shoot(browser, folder, 'handed_in')
    pdf = folder / 'print.pdf'
    pdf.write_bytes(base64.b64decode(browser.execute_cdp_cmd('Page.printToPDF', A4_IN)['data']))
    subprocess.run(['pdftoppm', '-r', '60', '-png', pdf, folder / 'print'], check=True)


def finished(browser: webdriver.Chrome, folder: Path) -> None:
    with started('view', str(folder / 'run'), '--at', '9') as view:
        browser.get(address(view))
        shoot(browser, folder, 'finished')


def live(browser: webdriver.Chrome, folder: Path) -> None:
    with started('simu', '--nb-robots', '8'), started('view') as view:
        browser.get(address(view))
        wait_for(lambda: browser.execute_script('return page.robots.length') == 8)
        with started('ctrl', '--algo', 'leader_follower_formation'):
            time.sleep(20)
            shoot(browser, folder, 'live')


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('folder', type=Path)
    folder = parser.parse_args().folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    with open_browser(1366, 768) as browser:
        for take in (handed_in, finished, live):
            take(browser, folder)


if __name__ == '__main__':
    main()
