import signal

import numpy as np
import pytest

from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_errors import ControlError, ErrorReports

POSES = np.zeros((3, 2))


def law(tmp_path, body):
    path = tmp_path / 'law.py'
    path.write_text(f'import numpy as np\ndef control(i, n, poses, t):\n    {body}\n')
    return ControlLaw(path, 2, 2)


def test_the_script_cannot_change_the_poses_of_others(tmp_path):
    poses = np.zeros((3, 2))

    law(tmp_path, 'poses[:] = 9; return 0, 0')(poses, 0.0)

    assert (poses == 0).all()


@pytest.mark.parametrize(
    ('body', 'message'),
    [
        ('exec("1 / 0")', r'line 3: ZeroDivisionError.*\n    3 \| exec'),
        ('raise type("Odd", (Exception,), {"__str__": lambda s: 1 / 0})', 'line 3: Odd: a Odd'),
        ('return type("Odd", (), {"__repr__": lambda s: 1 / 0})()', 'line 3: .* a Odd: a Odd'),
    ],
)
def test_failures_name_script_and_line_and_quote_it(tmp_path, body, message):
    with pytest.raises(ControlError, match=message):
        law(tmp_path, body)(POSES, 0.0)


def reported(*calls):
    """Return what is said of calls, each of a robot, its law and a time."""
    said = []
    reports = ErrorReports(said.append)
    for robot, called, t in calls:
        try:
            called(POSES, t)
            reports.succeeded(robot, t)
        except ControlError as error:
            reports.failed(robot, t, error)
    return said


def test_results_that_differ_in_their_values_only_are_one_error(tmp_path):
    failing = law(tmp_path, 'return i, t, None')

    said = reported(*((robot, failing, t) for t in (0.0, 0.2, 0.4) for robot in (1, 2)))

    assert [one.partition(': ')[2] for one in said[1:]] == ['the same error as tb3_1']


def test_each_distinct_error_is_reported_once(tmp_path):
    failing = law(tmp_path, 'return (1 / 0, 0) if t < 1 else poses[9] if t < 2 else (0, 0)')
    said = reported(*((2, failing, t) for t in (0.0, 0.2, 0.4, 1.0, 1.2, 2.0, 2.2)))

    assert len(said) == 3
    assert said[0].startswith('tb3_2 at t = 0.0 s: law.py, line 3: ZeroDivisionError')
    assert 'tb3_2 gets zero velocity' in said[0]
    assert 'IndexError' in said[1]
    assert said[2] == 'tb3_2 at t = 2.0 s: works again after 5 calls'


def test_the_users_interrupt_is_not_taken_for_a_fault_of_the_script(tmp_path):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's & ignores it
    try:
        with pytest.raises(KeyboardInterrupt):
            law(tmp_path, 'raise KeyboardInterrupt')(POSES, 0.0)
    finally:
        signal.signal(signal.SIGINT, before)


HOSTILE = """
import signal
import sys
class Odd(Exception):
    def __str__(self):
        {body}
    __repr__ = __array__ = __float__ = __len__ = __str__
class Number(float):
    def __float__(self):
        {body}
def control(i, n, poses, t):
    {call}
"""


@pytest.mark.parametrize(
    'call', ['raise Odd()', 'return Odd()', 'return Number(1), Number(2)', 'return Odd(), 1']
)
@pytest.mark.parametrize(
    'body', ['sys.exit(3)', 'raise KeyboardInterrupt', 'raise OSError', 'return 7']
)
def test_objects_that_cannot_be_described_stop_their_own_robot_only(tmp_path, call, body):
    path = tmp_path / 'law.py'
    path.write_text(HOSTILE.format(call=call, body=body))

    if call == 'return Number(1), Number(2)' and body == 'return 7':
        return  # it is a number
    with pytest.raises(ControlError, match=r'law\.py'):
        ControlLaw(path, 1, 2)(POSES, 0.0)


@pytest.mark.parametrize(
    ('text', 'shown'),
    [(r'a\ud800b', r'a\ud800b'), (r'a\0b', r'a\x00b'), (r'\x1b[2J', r'\x1b[2J')],
)
def test_what_a_terminal_cannot_show_is_escaped(tmp_path, text, shown):
    with pytest.raises(ControlError) as failure:
        law(tmp_path, f"raise ValueError('{text}')")(POSES, 0.0)

    assert f'ValueError: {shown}' in str(failure.value)
    str(failure.value).encode()
