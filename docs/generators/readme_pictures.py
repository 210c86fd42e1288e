"""Makes the pictures of README.md and docs, from runs of its own.

python docs/generators/readme_pictures.py                   all of them
python docs/generators/readme_pictures.py browser_view      needs chromium and chromedriver
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2] / 'tests'))

from ros_domain import reserved_domain

DOCS = Path(__file__).parents[1]
PICTURES = DOCS / 'pictures'
SETCMAS = str(Path(sys.executable).parent / 'setcmas')
MOST_BYTES = 200_000
MOST_BYTES_OF_A_FILM = 1_500_000
WINDOW = (1280, 943)  # 1280 x 800 without the frame
RUNNING_S = 24.0
"""Time after which the formation is there and its trails are long."""


def save(source: Path, name: str) -> Path:
    """Write a picture as a small PNG, or a film as it is.

    Args:
        source: Any image, or a GIF that moves.
        name: What it is called in docs/pictures.
    """
    if source.suffix == '.gif':
        film = Path(shutil.copyfile(source, PICTURES / f'{name}.gif'))
        assert film.stat().st_size < MOST_BYTES_OF_A_FILM, f'{film}: {film.stat().st_size} bytes'
        return film
    path = PICTURES / f'{name}.png'
    with Image.open(source) as image:
        # Means of clusters: the robots' colours are rare, and a median would swallow them.
        small = image.convert('RGB').quantize(256, kmeans=8, dither=Image.Dither.NONE)
    small.save(path, optimize=True)
    assert path.stat().st_size < MOST_BYTES, f'{path}: {path.stat().st_size} bytes'
    return path


def plot_of_a_run(folder: Path, plot: str, *options: str) -> Path:
    """Let robots run offline, and return one of the plots."""
    subprocess.run(
        [SETCMAS, 'offline', *options, '--output', str(folder)],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return folder / 'plots' / f'{plot}.png'


def formation(folder: Path) -> Path:
    """Show a leader that visits waypoints, and the formation around it, as a film."""
    options = ('--algo', 'leader_follower_formation', '--nb-robots', '5', '--duration', '60')
    plot_of_a_run(folder, 'trajectories', *options)
    subprocess.run(
        [SETCMAS, 'csv_to_plot', str(folder), '--animate', 'gif', '--speed', '6'],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return folder / 'plots' / 'film.gif'


def swap(folder: Path) -> Path:
    """Show eight robots that change places, as the page on the safety filter tells, as a film."""
    page = (DOCS / 'safety_filter.md').read_text(encoding='utf-8')
    found = re.search(r'```python\n(# swap\.py.*?)```', page, re.DOTALL)
    assert found, 'the page has no swap.py'
    with tempfile.TemporaryDirectory() as scripts:
        script = Path(scripts) / 'swap.py'
        script.write_text(found[1], encoding='utf-8')
        options = ('--algo', str(script), '--nb-robots', '8', '--duration', '24', '--vnom', '0.3')
        circle = [math.tau * robot / 8 for robot in range(8)]
        poses = [
            f'--pose={i}:{2 * math.cos(a):.3f},{2 * math.sin(a):.3f},{a + math.pi:.3f}'
            for i, a in enumerate(circle, start=1)
        ]
        filtered = ('--filter', 'barrier', '--set', 'turn=20')
        plot_of_a_run(folder, 'trajectories', *options, *poses, *filtered)
    film = ('--animate', 'gif', '--speed', '3')
    subprocess.run(
        [SETCMAS, 'csv_to_plot', str(folder), *film], check=True, stdout=subprocess.DEVNULL
    )
    return folder / 'plots' / 'film.gif'


def communication(folder: Path) -> Path:
    """Show when robots sent their states in an event-triggered consensus."""
    options = ('--algo', 'consensus', '--nb-robots', '8', '--event-triggered')
    return plot_of_a_run(folder, 'communication_instants', *options)


def inter_event_times(folder: Path) -> Path:
    """Show the times between states in the run of the page on communication."""
    options = ('--algo', 'laplacian_consensus', '--nb-robots', '6', '--graph', 'path')
    condition = ('--event-triggered', '--ctc', 'garcia_2013')
    return plot_of_a_run(folder, 'inter_event_times', *options, *condition)


def graph(folder: Path) -> Path:
    """Show the graphs of the file that the page on communication explains."""
    page = (DOCS / 'communication.md').read_text(encoding='utf-8')
    found = re.search(r'```yaml\n(# switching\.yaml.*?)```', page, re.DOTALL)
    assert found, 'the page has no switching.yaml'
    with tempfile.NamedTemporaryFile('w', suffix='.yaml', encoding='utf-8') as file:
        file.write(found[1])
        file.flush()
        options = ('--algo', 'consensus', '--nb-robots', '4', '--graph', file.name)
        return plot_of_a_run(folder, 'graph', *options, '--duration', '60')


def notebook(folder: Path) -> Path:
    """Show a run as a notebook does."""
    from browser import open_browser

    from setcmas_tools import simulate

    shown = simulate('consensus', nb_robots=5, duration=40)._repr_html_()
    folder.mkdir()
    page = folder / 'run.html'
    page.write_text(f'<body style="font: 15px sans-serif">{shown}</body>', encoding='utf-8')
    with open_browser(960, 830) as browser:
        browser.get(page.as_uri())
        browser.save_screenshot(str(folder / 'run.png'))
    return folder / 'run.png'


def browser_view(folder: Path) -> Path:
    """Show a formation on its way, on the live page."""
    from browser import open_browser, wait_for

    with reserved_domain() as domain, contextlib.ExitStack() as stack:
        environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(domain),
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        }

        def start(*arguments: str) -> subprocess.Popen[str]:
            process = subprocess.Popen(
                [SETCMAS, *arguments],
                env=environment,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
            )
            stack.callback(process.wait)
            stack.callback(process.send_signal, signal.SIGINT)
            return process

        start('simu', '--nb-robots', '8', '--view', 'none')
        page = start('view', '--port', '8911')
        assert page.stdout
        found = (re.search(r'http://\S+', line) for line in page.stdout)
        url = next(match[0] for match in found if match)
        browser = stack.enter_context(open_browser(*WINDOW))
        browser.get(url)
        wait_for(lambda: browser.execute_script('return page.robots.length') == 8)
        start('ctrl', '--algo', 'leader_follower_formation')
        time.sleep(RUNNING_S)
        browser.find_elements('css selector', '#robots button')[0].click()
        folder.mkdir()
        browser.save_screenshot(str(folder / 'page.png'))
    return folder / 'page.png'


def report(folder: Path) -> Path:
    """Show a run at an instant on its page."""
    from browser import open_browser

    from setcmas_tools import simulate

    run = simulate('consensus', 8, 40.0, graph='ring', event_triggered=True)
    run.save(folder / 'run')
    page = folder / 'run.html'
    subprocess.run(
        [SETCMAS, 'report', folder / 'run', '-o', page],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    with open_browser(*WINDOW) as browser:
        browser.get(f'{page.as_uri()}#t=9')
        browser.find_elements('css selector', '#robots button')[2].click()
        time.sleep(2.0)
        browser.save_screenshot(str(folder / 'page.png'))
    return folder / 'page.png'


MAKERS = {
    maker.__name__: maker
    for maker in (
        formation,
        swap,
        communication,
        inter_event_times,
        graph,
        notebook,
        browser_view,
        report,
    )
}


def main() -> None:
    """Make the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', metavar='NAME', help=f'any of {", ".join(MAKERS)}')
    names = parser.parse_args().names or list(MAKERS)
    if unknown := set(names) - set(MAKERS):
        parser.error(f'{", ".join(unknown)} is none of {", ".join(MAKERS)}')
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            print(save(MAKERS[name](Path(folder) / 'run'), name))


if __name__ == '__main__':
    main()
