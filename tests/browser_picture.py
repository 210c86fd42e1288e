"""Takes the picture of the browser view that README shows; needs chromium and chromium-driver.

python tests/browser_picture.py docs/browser_view.png
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from browser import buttons, close_notifications, open_browser, wait_for, wait_for_text
from processes import SETCMAS
from ros_domain import reserved_domain

_WIDTH, _HEIGHT = 1280, 860
_RUN_TIME_S = 22.0


@contextlib.contextmanager
def _started(log: Path, *arguments: str) -> Iterator[None]:
    with log.open('wb') as file:
        process = subprocess.Popen([*SETCMAS, *arguments], stdout=file, stderr=file)
    try:
        yield
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()


def browser_picture(path: Path, algo: str = 'leader_follower_formation') -> None:
    """Write a picture of the page while eight robots run, seen in 3D.

    Args:
        path: A PNG file.
        algo: The control law.
    """
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        os.environ['ROS_DOMAIN_ID'] = str(stack.enter_context(reserved_domain()))
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
        stack.enter_context(_started(folder / 'view', 'view'))
        wait_for(lambda: 'http' in (folder / 'view').read_text())
        url = re.search(r'http://\S+', (folder / 'view').read_text())
        browser = stack.enter_context(open_browser(_WIDTH, _HEIGHT))
        browser.get(url.group())
        stack.enter_context(_started(folder / 'simu', 'simu', '--nb-robots', '8'))
        wait_for_text(browser, '8 robots')
        close_notifications(browser)
        buttons(browser)['3D'].click()
        stack.enter_context(_started(folder / 'ctrl', 'ctrl', '--algo', algo))
        wait_for_text(browser, 'run time')
        time.sleep(_RUN_TIME_S)
        browser.save_screenshot(str(path))


if __name__ == '__main__':
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('path', type=Path, help='the picture, a PNG file')
    browser_picture(parser.parse_args().path)
