"""Runs, checks and pages need numpy, PyYAML and matplotlib only: so they work in a browser.

Files of runs are read with msgspec, too: a page in a browser only writes them.
"""

import subprocess
import sys
from importlib.metadata import packages_distributions

IMPORTS = """
from setcmas_tools import Run, Scenario, check, simulate
import setcmas_tools.page.report_file
import setcmas_tools.page.site_worker
"""
LIBRARIES = {
    'numpy', 'yaml', 'matplotlib', 'mpl_toolkits',
    'PIL', 'contourpy', 'cycler', 'dateutil', 'fontTools', 'kiwisolver', 'packaging', 'pyparsing',
    'six', 'tabulate', 'wcwidth',
}  # fmt: skip
"""What may be imported: the three, what matplotlib needs, and what our archive brings."""

OTHERS = {
    'daqp', 'geometry_msgs', 'jinja2', 'joblib', 'lz4', 'mcap', 'msgspec', 'nav_msgs', 'pandas',
    'rclpy', 'rich', 'rosbags', 'scipy', 'starlette', 'std_msgs', 'tqdm', 'websockets',
}  # fmt: skip

LIST = f"""
import sys
before = set(sys.modules)
{IMPORTS}
tops = {{name.partition('.')[0] for name in sys.modules.keys() - before}}
print(*tops)
"""
REFUSE = """
import sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition('.')[0] in {names}:
            raise ModuleNotFoundError(name=name)

sys.meta_path.insert(0, Refuse())
"""
PAGE = f"""
{REFUSE.format(names=OTHERS | {'matplotlib', 'PIL'})}
import json

from setcmas_tools.page import site_worker

for law in ('consensus', 'nav_wp'):
    answer = json.loads(site_worker.answer('run', json.dumps({{'algo': law}})))
    print(answer['ok'], answer.get('needs'))
"""


def output_of(code, *arguments):
    command = [sys.executable, '-c', code, *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_only_these_libraries_are_imported():
    imported = set(output_of(LIST).split()) & packages_distributions().keys()

    assert {name for name in imported if not name.startswith('setcmas_')} <= LIBRARIES


def test_a_page_shows_a_run_without_a_task_before_it_has_matplotlib():
    assert output_of(PAGE).splitlines() == ['True None', 'False matplotlib']
