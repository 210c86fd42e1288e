import subprocess
import sys

import pytest
from metrics_runs import T, table, write_run

from setcmas_simu.errors import SetcmasError
from setcmas_tools.measures.task import with_task_of
from setcmas_tools.run.run import Run


@pytest.fixture
def run(tmp_path):
    return Run.load(write_run(tmp_path / 'run', table((T, 0.1 * T, 0), (T, 3 - 0.1 * T, 0))))


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ("task = 'waypoints'", 'defines no WPL'),
        ("task = 'waypoints'\nWPL = [1, 2]", r'WPL is \[1, 2\]; it must be points'),
        ("task = 'tracking'\nR = 2", 'defines no W'),
        ("task = 'dance'", "unknown task 'dance'; did you mean distances"),
        ('', "mine.py declares no task; add a line such as task = 'waypoints', one of alignment,"),
    ],
)
def test_references_that_a_script_does_not_define(run, tmp_path, text, message):
    path = tmp_path / 'mine.py'
    path.write_text(f'{text}\ndef control(*_): return 0, 0\n')

    with pytest.raises(SetcmasError, match=message):
        with_task_of(run, str(path))


def test_a_script_is_read_and_not_run(run, tmp_path):
    path = tmp_path / 'mine.py'
    path.write_text("WPL = [[1, 0]]\nREACHED = 0.055\ntask = 'waypoints'\nraise RuntimeError\n")

    visits = with_task_of(run, str(path)).metrics()['waypoints']

    assert visits.reached_at_s[1][0] == 9.5


def test_a_controller_that_reads_the_task_of_its_law_imports_nothing_of_runs():
    code = (
        'import sys; from setcmas_ctrl.laws.references import TASKS; '
        '[TASKS.get(name) for name in TASKS.plugins()]; '
        'print([m for m in sys.modules if m in ("setcmas_tools.run.run", "setcmas_expe")])'
    )
    found = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=True
    )

    assert found.stdout.strip() == '[]'
