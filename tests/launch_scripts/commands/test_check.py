"""`setcmas check`, in processes that hang, fail, and do what they should."""

from processes import run_here

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
