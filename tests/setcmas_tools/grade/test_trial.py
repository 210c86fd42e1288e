"""What `check` says of a script that `setcmas grade` would mark otherwise."""

import pytest

from setcmas_tools import check
from setcmas_tools.grade import trial
from setcmas_tools.offline.kernel_confinement import obstacle

RUBRIC = """\
solution: nav_wp
scenarios:
  - {name: short, nb_robots: 2, duration: 1, criteria: [{metric: path_length, at_least: 0}]}
"""
LAW = 'def control(robotNo, nbRobots, poses, t):\n    return 0.1, 0\n'
REFUSED = '`setcmas grade` refuses: law.py, line {}: PermissionError'
SHARING = "import os\nos.SEEN = hasattr(os, 'SEEN')\nassert not os.SEEN"
SCRIPTS = {
    "import os\nos.makedirs('out', exist_ok=True)": REFUSED.format(2),
    "open('/etc/hosts').close()": REFUSED.format(1),
    "import numpy\nnumpy.loadtxt('gains.csv')\nfrom helper import K": '',
    SHARING: '`setcmas grade` gives 1 of 1 points: each robot has its own process',
}


def checked(folder, head):
    files = {
        'r.yaml': RUBRIC,
        'law.py': f'{head}\n{LAW}',
        'gains.csv': '1 2',
        'helper.py': 'K = 1',
    }
    for name, content in files.items():
        (folder / name).write_text(content)
    return check(folder / 'law.py', folder / 'r.yaml')


@pytest.mark.skipif(bool(obstacle()), reason=obstacle())
@pytest.mark.parametrize('head', SCRIPTS)
def test_what_grade_would_refuse_is_said_in_a_line(tmp_path, monkeypatch, head):
    monkeypatch.chdir(tmp_path)

    result = checked(tmp_path, head)

    assert result.note.startswith(SCRIPTS[head])
    assert result.is_full == (not SCRIPTS[head]) == (not result.note)
    assert str(result).splitlines()[-1] == (result.note or '1 of 1 points')


def test_without_a_sandbox_check_says_that_it_could_not_try(tmp_path, monkeypatch):
    monkeypatch.setattr(trial, 'obstacle', lambda: 'win32 has no Landlock')

    result = checked(tmp_path, '')

    assert result.is_full
    assert str(result).endswith(
        'not tried in the sandbox of `setcmas grade`, which may refuse it: win32 has no Landlock'
    )
