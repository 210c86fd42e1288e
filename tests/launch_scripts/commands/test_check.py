"""`setcmas check`, in processes that hang, fail, and do what they should."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from processes import SETCMAS, run_here

GUIDE = Path(__file__).parents[3] / 'docs' / 'grading.md'

RUBRIC = """\
solution: nav_wp
scenarios:
  - name: short
    nb_robots: 2
    duration: 1
    criteria: [{name: near, metric: path_error, at_most: 0.1, hint: Nearer.}]
  - name: kept
    hidden: true
    duration: 1
    criteria: [{metric: path_error, at_most: 0.1}]
"""
LAW = """\
def control(robotNo, nbRobots, poses, t):
    while t > 0.5:
        pass
    return undefined if robotNo == 2 else (1, 0)
"""


def test_a_copy_of_a_law_has_all_points_and_a_picture(tmp_path):
    run_here('new', 'my_law', '--from', 'nav_wp', cwd=tmp_path)
    result = run_here('check', 'my_law', '--rubric', 'nav_wp', cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, '')
    assert '✓ 1/1  it reaches the first waypoint: waypoints_reached 11 (wanted' in result.stdout
    assert result.stdout.endswith(
        '10 of 10 points\nyour paths over those of the solution: my_law_check.png\n'
    )
    assert (tmp_path / 'my_law_check.png').read_bytes().startswith(b'\x89PNG')


def test_a_failure_is_reported_with_the_line_of_the_script(tmp_path):
    (tmp_path / 'r.yaml').write_text(RUBRIC)
    (tmp_path / 'law.py').write_text(LAW)
    arguments = ('check', 'law.py', '-R', 'r.yaml')
    hanging = run_here(*arguments, '--call-timeout', '1', cwd=tmp_path)
    (tmp_path / 'law.py').write_text(LAW.replace('while', 'if'))
    failing = run_here(*arguments, cwd=tmp_path)
    assert (hanging.returncode, failing.returncode) == (1, 1)
    assert (
        '  tb3_1: control has not returned for 1 s (--call-timeout) at law.py, line'
        in hanging.stdout
    )
    assert "  tb3_2 at t = 0.0 s: law.py, line 4: NameError: name 'undefined'" in failing.stdout
    assert '      4 | return undefined if robotNo == 2' in failing.stdout
    assert (
        '✗ 0/1  near: path_error none: the script failed (wanted: at most 0.1 m)\n'
        in hanging.stdout
    )
    assert 'kept' not in failing.stdout
    assert 'Nearer' not in failing.stdout  # it would lead away from the mistake


RIGHT = 'def control(robotNo, nbRobots, poses, t):\n    return 0.0, 0.0\n'
STILL = RUBRIC.replace('solution: nav_wp', 'solution: right.py')


@pytest.mark.parametrize(
    ('law', 'status', 'score', 'code'),
    [
        (RIGHT, 'right', 1.0, 0),
        (RIGHT.replace('0.0, 0', '0.5, 0'), 'incomplete', 0.0, 1),
        (LAW.replace('while', 'if'), 'failed', 0.0, 1),
    ],
)
def test_json_has_marks_hints_and_status_for_programs(tmp_path, law, status, score, code):
    for name, text in {'r.yaml': STILL, 'right.py': RIGHT, 'law.py': law}.items():
        (tmp_path / name).write_text(text)

    result = run_here('check', 'law.py', '-R', 'r.yaml', '--json', cwd=tmp_path)

    found = json.loads(result.stdout)
    [scenario] = found['marks']['scenarios']
    [criterion] = scenario['criteria']
    failure = scenario['failure'] or {'message': ''}
    assert (result.returncode, found['status'], found['score']) == (code, status, score)
    assert (criterion['points'], criterion['max_points'], found['max_score']) == (score, 1, 1)
    assert ("NameError: name 'undefined'" in failure['message']) == (status == 'failed')
    assert bool(criterion['hint']) == (status == 'incomplete')
    assert not list(tmp_path.glob('*.png'))
    both = run_here('check', 'law.py', '-R', 'r.yaml', '--json', '--show', cwd=tmp_path)
    assert both.returncode == 2
    assert 'leave out --show' in both.stderr


@pytest.mark.parametrize(
    ('law', 'score', 'output'),
    [(RIGHT, 1, 'reached 0 m'), ('def control(', 0, "SyntaxError: '(' was never closed")],
)
@pytest.mark.nightly
def test_the_autograder_of_the_guide_writes_what_gradescope_reads(tmp_path, law, score, output):
    text = re.search(r'^`run_autograder`:.*?^```python\n(.*?)^```', GUIDE.read_text(), re.S | re.M)
    files = {
        'source/rubric.yaml': STILL,
        'source/right.py': RIGHT,
        'submission/law.py': law,
        'results/none': '',
        'venv/bin/setcmas': f'#!/bin/sh\nexec {" ".join(map(str, SETCMAS))} "$@"\n',
        'run_autograder': text[1].replace("'/autograder'", repr(str(tmp_path))),
    }
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content)
    (tmp_path / 'venv/bin/setcmas').chmod(0o755)

    subprocess.run([sys.executable, tmp_path / 'run_autograder'], check=True)

    results = json.loads((tmp_path / 'results/results.json').read_text())
    tests = results.get('tests', [results])  # Gradescope adds up the tests, or takes the score
    assert sum(one['score'] for one in tests) == score
    assert output in tests[0]['output']
