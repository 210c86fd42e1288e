import numpy as np
import pytest
from plugins import add_plugins

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.models import MODELS
from setcmas_simu.robots.unicycle import BURGER_SHAPE
from setcmas_tools import simulate


class Hovercraft(RobotModel):
    shape = BURGER_SHAPE
    V_max = 1.0

    def __init__(self, fault=None, since=5):
        self.fault, self.steps_left = fault, since

    def step(self, states, commands, Ts):
        del commands, Ts
        self.steps_left -= 1
        later = states.copy()
        later[0] += 0.1
        if self.fault and self.steps_left < 0:
            later = self.fault(later)
        return later


def nan(later):
    later[1, 0] = np.nan
    return later


FAULTS = {
    'NaN': (nan, r'step returned NaN or inf \(test_plugin_model.py, line \d+\)'),
    'shape': (lambda later: later[:2], r'step returned an array \(2, 2\), not \(6, 2\) \(.*\)'),
    'text': (lambda _: 'fast', r'ValueError: .* \(\w+.py, line \d+\)'),
    'error': (lambda _: 1 / 0, r'ZeroDivisionError: .*test_plugin_model.py, line \d+\)'),
}


@pytest.mark.parametrize('name', FAULTS)
def test_a_model_of_a_package_that_fails_is_named_and_its_robots_stop(monkeypatch, name):
    fault, reason = FAULTS[name]
    add_plugins(monkeypatch, MODELS, hovercraft=Hovercraft(fault))
    messages = []

    run = simulate('consensus', 2, 2, model='hovercraft', warn=messages.append)

    assert np.isfinite(run.poses).all()
    assert (run.poses[-1, 0] - run.poses[0, 0]).tolist() == pytest.approx([0.5, 0.5])
    assert run.outcome.failed_laws == {'hovercraft': [1, 2]}
    (message,) = messages
    start = "robot model 'hovercraft' of package my-lab 1.0: "
    assert message.startswith(start)
    with pytest.raises(AssertionError, match=f'^{reason}; its robots stop$'):
        raise AssertionError(message.removeprefix(start))


def test_a_model_that_fails_at_its_start_ends_the_run(monkeypatch):
    hovercraft = Hovercraft()
    hovercraft.start = lambda poses: poses
    add_plugins(monkeypatch, MODELS, hovercraft=hovercraft)

    with pytest.raises(SetcmasError, match=r'my-lab 1.0: start returned an array \(3, 2\)'):
        simulate('consensus', 2, 2, model='hovercraft')


def test_a_model_of_a_package_moves_as_it_says(monkeypatch):
    add_plugins(monkeypatch, MODELS, hovercraft=Hovercraft())

    run = simulate('consensus', 2, 2, model='1:hovercraft')

    assert run.outcome.state.value == 'complete'
    assert run.poses[-1, 0, 0] - run.poses[0, 0, 0] == pytest.approx(2.0)
