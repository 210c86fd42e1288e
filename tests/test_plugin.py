"""A package of somebody else's, installed from its wheel, and used by name on the command line."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.nightly

PLUGIN = Path(__file__).parent / 'plugin'
DOCS = Path(__file__).parents[1] / 'docs'
PAGES = [DOCS / 'extending.md', DOCS / 'robot_models.md']
MAIN = 'from launch_scripts.cli import main; raise SystemExit(main())'


@pytest.fixture(scope='session')
def setcmas(tmp_path_factory):
    """Install the plugin beside what is installed here; returns a function that runs setcmas."""
    folder = tmp_path_factory.mktemp('plugin')
    shutil.copytree(PLUGIN, folder / 'source')
    pip = [sys.executable, '-m', 'pip', '--quiet', '--disable-pip-version-check']
    options = ['--no-deps', '--no-index', '--no-build-isolation', '--target', folder / 'packages']
    subprocess.run([*pip, 'install', *options, folder / 'source'], check=True)

    def run(*arguments, cwd=None):
        return subprocess.run(
            [sys.executable, '-c', MAIN, *arguments],
            cwd=cwd or folder,
            env={**os.environ, 'PYTHONPATH': str(folder / 'packages')},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def test_list_shows_what_it_offers_and_what_cannot_be_used(setcmas):
    result = setcmas('list')

    assert result.returncode == 0
    for line in (
        'spiral .*Spiral: robots go round a centre',
        'hovercraft .*A first-order lag in speed and turn rate',
        r'beacon .*PoseStamped on /beacon/\{name\}/pose',
        'frames .*TFMessage on /frames',
        'excursion .*The largest distance of each robot',
        'radius .*Draw the distance from the origin',
        r'broken .*\(cannot be used: RuntimeError: no licence found \(broken.py, line 3\)\)',
        r'brick .*\(cannot be used: it is a str; it must be a RobotModel\)',
        r"no_topic .*\(cannot be used: topic 'no topic' must be the full name",
        r'lost .*\(cannot be used: its module example_lab.no_such_module was not found\)',
    ):
        pattern = rf'^ *{line}'.replace(' .*', r' +example-lab 0\.3 .*', 1)
        assert re.search(pattern, result.stdout, re.MULTILINE), (line, result.stdout)


def test_law_model_metric_and_plot_are_used_by_name(setcmas, tmp_path):
    options = ('--algo', 'spiral', '--model', '1:hovercraft', '--nb-robots', '3')
    result = setcmas('offline', *options, '--duration', '20', '-o', 'out', cwd=tmp_path)

    assert result.returncode == 0, result.stderr
    assert 'excursion' in result.stdout
    assert (tmp_path / 'out' / 'plots' / 'radius.png').is_file()
    assert (tmp_path / 'out' / 'plots' / 'trajectories.png').is_file()
    told = [line for line in result.stderr.splitlines() if 'cannot be used' in line]
    assert len(told) == 2
    assert "metric 'broken' of package example-lab 0.3 cannot be used" in result.stderr
    assert "plot 'unplotted' of package example-lab 0.3 cannot be used" in result.stderr


def test_motion_capture_is_used_by_name(setcmas, domain):
    pytest.importorskip('rclpy')
    result = setcmas('doctor', '--emulate', '--mocap', 'beacon')

    (robot,) = (line for line in result.stdout.splitlines() if line.startswith('tb3_1'))
    assert ' Hz ' in robot
    assert result.returncode == 0, result.stdout


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.stem)
def test_the_pages_show_the_files_of_this_package(page):
    tomllib = pytest.importorskip('tomllib')
    text = page.read_text()
    files = re.findall(r'`example_lab/(\w+)\.py`:\n\n```python\n(.*?)```', text, re.DOTALL)
    (entry_points,) = re.findall(r'```toml\n(.*?)```', text, re.DOTALL)
    offered = tomllib.loads((PLUGIN / 'pyproject.toml').read_text())['project']['entry-points']

    assert files
    for name, code in files:
        assert code == (PLUGIN / 'example_lab' / f'{name}.py').read_text()
    for group, shown in tomllib.loads(entry_points)['project']['entry-points'].items():
        assert shown.items() <= offered[group].items()
