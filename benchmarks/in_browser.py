"""Measures runs in Chromium with Pyodide; prints figures, asserts nothing.

Needs chromium and chromium-driver, and the network once, for Pyodide. Run in the environment that
setcmas is installed in, on a quiet machine:

    python benchmarks/in_browser.py [--runs 50] [--duration 60]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))

from pyodide_browser import PyodideBrowser, pyodide_browser
from quick_option import parsed


def timed(browser: PyodideBrowser, call: str, **request) -> str:
    answer, _ = browser.call(call, **request)
    assert answer['ok'], answer
    alone = f', the simulation {answer["seconds"]:.3f} s' if 'seconds' in answer else ''
    return f'{answer["took"]:.2f} s{alone}'


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--runs', type=int, default=50)
    parser.add_argument('--duration', type=float, default=60.0)
    args = parsed(parser, runs=1, duration=5.0)
    request = {'algo': 'consensus', 'scenario': {'nb_robots': 8, 'duration': args.duration}}
    with pyodide_browser() as browser:
        print(f'setcmas: {browser.packages.stat().st_size / 1e6:.2f} MB')
        for part, seconds in browser.laps.items():
            print(f'{part}: {seconds:.2f} s')
        print(f'8 robots for {args.duration:g} s, until the page has the content of its player:')
        for number in ('first', 'second', 'third'):
            print(f'  {number} run: {timed(browser, "run", **request)}')
        print(f'memory: {browser.memory_mb():.0f} MB')
        for _ in range(args.runs):
            browser.call('run', **request)
        print(f'memory after {args.runs} more runs: {browser.memory_mb():.0f} MB')
        for call in ('report_html', 'report_html', 'plots'):
            print(f'{call}: {timed(browser, call)}')


if __name__ == '__main__':
    main()
