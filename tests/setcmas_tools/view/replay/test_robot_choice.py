from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('viser')
from setcmas_tools import simulate
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.replay.main import ReplayView
from setcmas_tools.view.replay.options import ReplayOptions


@pytest.fixture
def view():
    page = Page('127.0.0.1', 18970)
    runs = {name: simulate('consensus', 3, 2.0, delay=0.3) for name in ('one', 'other')}
    shown = ReplayView(page, runs, ReplayOptions(beside=True))
    shown.show(1.0)
    yield shown
    page.stop()


def click(view, x, y):
    """Click what is at a place on the ground; returns what is told of the robot there."""
    eye = np.array([1.0, -9.0, 7.0])
    along = np.array([x, y, 0.0]) - eye
    view._robot._on_click(SimpleNamespace(ray_origin=eye, ray_direction=along))
    view.show(1.0)
    return view._robot._text.content


def test_a_click_on_a_robot_tells_of_it(view):
    state = view._states[0]
    x, y, _ = state.fleet.newest()[:, 1]
    told = click(view, x + 0.1, y - 0.1)

    assert 'tb3_2' in told
    assert f'{x:.3f} m' in told
    assert '(the largest speed)' in told
    assert 'tb3_2' in click(view, 0.0, 1.0)  # nobody is there


def test_a_click_on_the_second_run_tells_of_that_one(view):
    state, offset_m = view._states[1], view._second.offset_m
    x, y, _ = state.fleet.newest()[:, 2]
    click(view, x + offset_m, y)

    assert view._robot._list.value == 'robot 3 of the second run'
