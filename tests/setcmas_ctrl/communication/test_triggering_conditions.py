import math

import numpy as np
import pytest

from setcmas_ctrl.communication.triggering_conditions import CONSEQUENCE, Broadcast, further_than
from setcmas_ctrl.scripts.script_errors import ErrorReports
from setcmas_simu.errors import SetcmasError


@pytest.fixture
def said():
    return []


@pytest.fixture
def broadcast(tmp_path, said):
    """Load a condition from the text of a script, or the default one."""

    def broadcast(text=None, threshold=0.25):
        reports = ErrorReports(said.append, CONSEQUENCE)
        path = tmp_path / 'when.py'
        if text is None:
            return Broadcast(3, further_than(threshold), path, reports)
        path.write_text(text)
        return Broadcast.of_script(3, path, reports)

    return broadcast


def decisions(broadcast, xs, V=0.0):
    return [broadcast.is_triggered((x, 0.0, 0.0), V, 0.1 * k) for k, x in enumerate(xs)]


def test_the_default_condition():
    here, ctc = np.zeros(3), further_than(0.25)

    assert not ctc(here, np.array([0.25, 0.0, 0.0]), 0.0)
    assert ctc(here, np.array([0.2, 0.16, 0.0]), 0.0)


def test_the_first_state_is_sent_and_then_each_quarter_of_a_metre(broadcast):
    xs = np.arange(0, 1.0, 0.1)

    assert decisions(broadcast(), xs) == [k % 3 == 0 for k in range(10)]
    assert decisions(broadcast(threshold=0.45), xs) == [k % 5 == 0 for k in range(10)]


def test_a_condition_with_three_arguments_gets_positions_and_time(broadcast):
    own = broadcast('def ctc(pos, last_pos, t):\n    return t > 0.25 and pos[0] > last_pos[0]\n')

    assert decisions(own, [5, 6, 6, 6, 6, 7]) == [True, False, False, True, False, True]


def test_a_condition_with_five_arguments_gets_velocities_in_the_world_frame(broadcast):
    own = broadcast(
        'def ctc(pos, vit, last_pos, last_vit, t):\n'
        '    assert pos.shape == vit.shape == last_pos.shape == last_vit.shape == (3,)\n'
        '    return abs(vit[1] - last_vit[1]) > 0.1\n'
    )
    east, north = (0.0, 0.0, 0.0), (0.0, 0.0, math.pi / 2)

    assert own.is_triggered(east, 0.2, 0.0)
    assert not own.is_triggered(east, 0.5, 0.1)
    assert own.is_triggered(north, 0.5, 0.2)
    assert not own.is_triggered(north, 0.5, 0.3)


def test_a_condition_cannot_change_what_was_sent(broadcast):
    own = broadcast('def ctc(pos, last_pos, t):\n    last_pos += 9\n    return last_pos[0] != 9\n')

    assert decisions(own, [0, 1, 2]) == [True, False, False]


@pytest.mark.parametrize('result', ['1', 'np.bool_(True)', 'np.array([1.5])', 'np.True_'])
def test_what_counts_as_true(broadcast, said, result):
    own = broadcast(f'import numpy as np\ndef ctc(pos, last_pos, t):\n    return {result}\n')

    assert decisions(own, [0, 0]) == [True, True]
    assert not said


@pytest.mark.parametrize(
    ('body', 'message'),
    [
        ('return 1 / 0', 'when.py, line 2: ZeroDivisionError'),
        ('raise SystemExit', 'SystemExit'),
        ('return None', 'line 2: ctc returned None; it must return True or False'),
        ('return pos > last_pos', 'line 2: ctc returned 3 values: array'),
        ("return float('nan')", 'ctc returned a value that is not finite: nan'),
    ],
)
def test_a_condition_that_fails_counts_as_a_trigger_and_is_reported_once(
    broadcast, said, body, message
):
    own = broadcast(f'def ctc(pos, last_pos, t):\n    {body}\n')

    assert decisions(own, [0, 0, 0, 0]) == [True] * 4
    assert len(said) == 1
    assert 'tb3_3 at t = 0.1 s' in said[0]
    assert message in said[0]
    assert 'tb3_3 sends its state whenever the condition fails' in said[0]


def test_a_condition_that_works_again_is_reported_too(broadcast, said):
    own = broadcast('def ctc(pos, last_pos, t):\n    return 1 / int(pos[0]) < 0\n')

    assert decisions(own, [1, 0, 0, 1]) == [True, True, True, False]
    assert 'works again after 2 calls' in said[-1]


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('def control(a, b, c, d):\n    return 0, 0\n', 'when.py has no function ctc'),
        ('def ctc(pos):\n    return True\n', r'ctc\(pos\) takes neither 3 nor 5 arguments'),
        ('ctc = 3\n', 'has no function ctc'),
        ('def ctc(pos, last_pos, t, *, content): ...\n', 'takes neither 3 nor 5 arguments'),
    ],
)
def test_scripts_that_have_no_condition(broadcast, text, message):
    with pytest.raises(SetcmasError, match=message):
        broadcast(text)


@pytest.mark.parametrize('positions', ['pos, last_pos', 'pos, vit, last_pos, last_vit'])
def test_a_condition_may_take_the_values_of_messages(broadcast, positions):
    own = broadcast(
        f'def ctc({positions}, t, *, value, last_value=3):\n'
        '    return last_value is None or abs(value["x"] - last_value["x"]) > 1\n'
    )
    decided = []
    for x in (0.0, 1.0, 1.5, 2.0, 2.6, 3.7):
        own.value = {'x': x} if x else None
        decided.append(own.is_triggered((0.0, 0.0, 0.0), 0.0, x))

    assert decided == [True, True, False, False, True, True]
