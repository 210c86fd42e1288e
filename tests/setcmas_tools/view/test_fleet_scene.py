import numpy as np
import pytest

pytest.importorskip('viser')
from setcmas_simu.fleet import fleet
from setcmas_tools.view.fleet_scene import FleetScene
from setcmas_tools.view.model.communication import links
from setcmas_tools.view.model.fleet_state import NO_PAIRS, FleetState
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.scene.tone import untoned

GREY_LINK = untoned([0.62, 0.66, 0.72])


@pytest.fixture
def state():
    return FleetState()


@pytest.fixture
def draw(state):
    """Draw what is known at a time, on a page that nobody looks at; returns viser's bodies."""
    page = Page('127.0.0.1', 18995)
    scene = FleetScene(page.server, state, None)

    def draw_at(now):
        scene.update(now)
        return page.server.scene._handle_from_node_name

    draw_at.figures = lambda: scene.controls._figures.content
    yield draw_at
    page.stop()


def see(state, robots, now):
    for robot in robots:
        state.fleet.see(robot, (float(robot), 0.5 * now, 0.1), 0.5, now)


def test_fleets_that_come_grow_and_go(state, draw):
    draw(0.0)
    see(state, [1], 1.0)
    draw(1.0)
    see(state, range(1, 51), 2.0)
    assert '/numbers/50' in draw(2.0)
    draw(60.0)
    see(state, [2], 61.0)
    bodies = draw(61.0)

    assert '/numbers/2' in bodies
    assert '/numbers/50' not in bodies


def test_robots_that_are_announced_but_not_seen_are_named(state, draw):
    state.announced = [1, 2, 3]
    see(state, [1], 1.0)
    draw(1.0)
    assert 'robots 2-3 are announced, but not seen' in draw.figures()

    see(state, [2, 3], 2.0)
    draw(3.0)
    assert 'not seen' not in draw.figures()


def test_a_robot_that_is_told_to_be_very_far_away_does_not_take_the_ground_along(state, draw):
    state.fleet.see(1, (1e12, 0.0, 0.0), 0.5, 1.0)
    bodies = draw(1.0)

    assert sum(name.startswith('/metres/') for name in bodies) < 100


def test_links_one_way_are_arrows_in_the_colour_of_who_has_just_sent(state, draw):
    see(state, [1, 2, 3], 1.0)
    ring = np.roll(np.eye(3), 1, axis=1)  # robot 1 hears 2, 2 hears 3, 3 hears 1
    state.both, state.one_way = links(ring)
    state.flashes.trigger(2, 1.0)
    arrows = draw(1.0)['/one_way_links']
    assert arrows.points.shape == (3, 2, 3)
    sender = state.one_way[:, 0].tolist().index(2)
    own = untoned(fleet.plot_colour(2))
    np.testing.assert_allclose(arrows.colors[sender] / 255, own, atol=0.01)
    later = draw(3.0)['/one_way_links']
    np.testing.assert_allclose(later.colors[sender] / 255, GREY_LINK, atol=0.01)

    state.both, state.one_way = links(ring + ring.T)
    bodies = draw(3.1)
    assert bodies['/links'].points.shape == (3, 2, 3)
    assert '/one_way_links' not in bodies
    state.both, state.one_way = NO_PAIRS, NO_PAIRS
    assert '/links' not in draw(3.2)


def test_robots_look_like_their_models(state, draw):
    see(state, [1, 2, 3], 1.0)
    state.models = {2: 'car', 3: 'omnidirectional'}
    bodies = draw(1.0)

    for name in ('unicycle', 'car', 'omnidirectional'):
        shown = bodies[f'/robots/{name}/coloured'].batched_scales
        assert (shown > 0).all(axis=1).sum() == 1


def test_a_run_that_has_ended_stays_as_it_was_until_another_begins(state, draw):
    see(state, [1, 2, 3], 1.0)
    draw(1.0)
    state.ended = True
    bodies = draw(100.0)
    assert 'run ended' in draw.figures()
    assert '3 robots' in draw.figures()
    assert 'lost' not in bodies['/numbers/3'].text

    state.begin()
    see(state, [1, 2], 101.0)
    bodies = draw(101.0)
    assert '/numbers/3' not in bodies
    assert '2 robots' in draw.figures()
