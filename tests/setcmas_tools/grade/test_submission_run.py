"""Runs of submissions in the sandbox: they drive and fail exactly as they do offline."""

import numpy as np
import pytest
from sandboxes import needs_sandbox, run

from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_simu.script_calls import Function
from setcmas_tools import simulate
from setcmas_tools.grade.submission_run import Times
from setcmas_tools.run.scenario import Scenario

pytestmark = needs_sandbox

FLEET = Scenario.of('', nb_robots=5, duration=8.0)
LOSSY = FLEET.replace(graph='ring', loss=0.2, noise=0.01)
TRIGGERED = FLEET.replace(algo='consensus', event_triggered=True)
LAWS = ('consensus', 'traj_tracking')


def same(one, other):
    pairs = zip(vars(one.table).values(), vars(other.table).values(), strict=True)
    return all(np.array_equal(*pair) for pair in pairs)


DRAWING = """
import random
import numpy as np
from setcmas_ctrl import network
K = 1
rng = np.random.default_rng()
other = random.Random()
def control(i, n, poses, t):
    vx = 0.1 * rng.random() * other.random() * random.random()
    return vx, K * len(network.neighbours()) * poses[0, i - 1]
"""
DRIVER = """
import random
n = 0
def si_to_uni(velocity, pose, komega):
    global n
    n += 1
    return velocity[0] + 0.01 * n, komega * velocity[1] + pose[2] * random.random()
"""
CONDITION = """
def ctc(pos, vit, last_pos, last_vit, t):
    return abs(pos - last_pos).sum() > 0.2
"""
SAME = {
    **{name: (ALGORITHMS.file(name).read_text(), FLEET, Function.CONTROL) for name in LAWS},
    'random numbers, links and settings': (
        DRAWING, LOSSY.replace(seed=3, set={'K': -0.1}), Function.CONTROL
    ),
    'condition': (CONDITION, TRIGGERED, Function.CONDITION),
    'own si_to_uni': (DRIVER, LOSSY.replace(algo='consensus', komega=2.0), Function.SI_TO_UNI),
}  # fmt: skip


@pytest.mark.parametrize('name', SAME)
def test_a_script_in_a_sandbox_does_as_it_does_offline_to_the_last_bit(tmp_path, name):
    source, scenario, function = SAME[name]
    (tmp_path / 'law.py').write_text(source)

    done = run(source, scenario, function=function)

    place = {Function.CONTROL: 'algo'}.get(function, function.value)
    assert same(done.run, simulate(scenario, **{place: tmp_path / 'law.py'}))
    assert done.failure is None


TALKING = """
from setcmas_ctrl import network
def control(i, n, poses, t):
    received = network.received()
    network.send({'x': poses[0, i - 1], 'v': [i, t]})
    if round(t, 1) == 1.0:
        1 / 0
    total = sum(one.age * one.value['x'] + one.value['v'][0] for one in received.values())
    return 0.02 * total, 0.1 * len(received)
"""


@pytest.mark.parametrize('scenario', [LOSSY.replace(delay=0.15), FLEET.replace(duration=3.0)])
def test_a_law_in_a_sandbox_uses_messages_as_it_does_offline(tmp_path, scenario):
    (tmp_path / 'law.py').write_text(TALKING)

    own = simulate(scenario, algo=tmp_path / 'law.py', warn=str)
    done = run(TALKING, scenario)

    assert same(done.run, own)
    assert 'ZeroDivisionError' in done.failure.message
    assert [(one.t, one.robot, one.value['x']) for one in done.run.messages] == [
        (one.t, one.robot, one.value['x']) for one in own.messages
    ]
    assert done.run.record.links == own.record.links


def test_an_endless_loop_is_reported_with_its_line():
    script = 'def control(i, n, poses, t):\n    while t > 0:\n        pass\n    return 0, 0\n'

    failure = run(script, times=Times(0.3, 4.0)).failure

    assert failure.message[:-2] == 'control has not returned for 0.3 s (law.py, line '
    assert (failure.message[-2:], failure.robot, failure.t) in (('2)', 1, 0.2), ('3)', 1, 0.2))
