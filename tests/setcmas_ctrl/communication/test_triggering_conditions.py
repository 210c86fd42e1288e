import math

import numpy as np
import pytest

from setcmas_ctrl.communication.graph import PRESETS
from setcmas_ctrl.communication.triggering_conditions import (
    CONSEQUENCE,
    CTC,
    Broadcast,
    further_than,
)
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate


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
        return Broadcast(3, load_script(path, 3, CTC).ctc, path, reports)

    return broadcast


def decisions(broadcast, xs, V=0.0):
    return [broadcast.is_triggered((x, 0.0, 0.0), V, 0.1 * k) for k, x in enumerate(xs)]


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


@pytest.mark.parametrize('result', ['1', 'np.bool_(True)', 'np.array([1.5])'])
def test_what_counts_as_true(broadcast, said, result):
    own = broadcast(f'import numpy as np\ndef ctc(pos, last_pos, t):\n    return {result}\n')

    assert decisions(own, [0, 0]) == [True, True]
    assert not said


@pytest.mark.parametrize(
    ('body', 'message'),
    [
        ('return 1 / 0', 'when.py, line 2: ZeroDivisionError'),
        ('return pos > last_pos', 'line 2: ctc returned 3 values: array'),
        ('return None', 'line 2: ctc returned None; it must return True or False'),
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


def test_a_condition_gets_the_poses_of_its_neighbours(broadcast):
    own = broadcast(
        'def ctc(pos, last_pos, t, *, received, measured):\n'
        '    received[:] = 0  # a copy\n'
        '    return measured.shape[1] > 0 and measured[0, 1] > 5\n'
    )
    assert decisions(own, [0, 0]) == [True, False]  # its law was not called yet
    poses = np.array([[1.0, 6.0], [2.0, 4.0], [0.0, 0.0]])
    own.see(poses, poses, np.array([0.0, 1.0]))
    assert own.is_triggered((0.0, 0.0, 0.0), 0.0, 0.2)
    own.see(poses, poses, np.array([1.0, 0.0]))
    assert not own.is_triggered((0.0, 0.0, 0.0), 0.0, 0.3)
    assert poses.any()


H, K, SIGMA = 0.04, 0.2, 0.5  # period (s), gain (1/s), and the constant of two conditions
OF_THEORY = {'model': 'omnidirectional', 'vnom': 50, 'rate': 1 / H, 'robot_rate': 1 / H}


def integrators(starts, A, duration, sends):
    """Simulate p' = -K L p_sent; return p at the end and the times of each robot's states.

    The condition `sends` gets p, p_sent, and L p and L p_sent as they were at the law's call, with
    the robot's own p or p_sent in it as it is now.
    """
    p, sent, times = starts.copy(), starts.copy(), [[0.0] for _ in starts]
    degree = A.sum(axis=1)[:, None]
    for k in range(1, round(duration / H) + 1):
        pull, pull_sent = A @ p, A @ sent
        p = p - H * K * (degree * sent - pull_sent)
        now = sends(p, sent, degree * p - pull, degree * sent - pull_sent, degree, k * H)
        sent[now] = p[now]
        for robot in np.flatnonzero(now):
            times[robot].append(k * H)
    return p, times


def relative(which):
    def sends(p, sent, z, z_sent, degree, t):
        most = SIGMA / (4 * degree[:, 0] ** 2)  # of a (1 - a d) / d, at a = 1 / (2 d)
        gaps = (z, z_sent)[which]
        return ((p - sent) ** 2).sum(axis=1) > most * (gaps**2).sum(axis=1)

    return sends


def falling(p, sent, z, z_sent, degree, t):
    return np.hypot(*(p - sent).T) > 0.02 + np.exp(-0.1 * t)


@pytest.mark.parametrize(
    ('name', 'sends', 'c0'),
    [
        ('dimarogonas_2012', relative(0), 0.0),
        ('garcia_2013', relative(1), 0.0),
        ('seyboth_2013', falling, 0.02),
    ],
)
@pytest.mark.parametrize('graph', ['ring', 'star'])
def test_conditions_of_the_literature_do_what_their_theorems_say(name, sends, c0, graph):
    A = PRESETS[graph](5)
    values = np.linalg.eigvalsh(np.diag(A.sum(axis=1)) - A)
    duration = np.ceil(9 / (K * values[1]))
    run = simulate(
        'laplacian_consensus', 5, duration, set={'K': K, 'SLOW': 0}, graph=graph,
        random_poses='auto', event_triggered=True, ctc=name, seed=2, **OF_THEORY,
    )  # fmt: skip
    starts, end = run.poses[0, :2].T, run.poses[-1, :2].T
    p, times = integrators(starts, A, duration, sends)

    np.testing.assert_allclose(end, p, atol=1e-4)
    assert run.metrics()['messages'].least_interval_s == pytest.approx(
        min(np.diff(own).min() for own in times)
    )
    np.testing.assert_allclose(end.mean(axis=0), starts.mean(axis=0), atol=1e-4)
    apart = np.hypot(*(end - end.mean(axis=0)).T)
    assert np.sqrt(np.mean(apart**2)) < values[-1] * c0 / values[1] + 0.005
