import pytest

pytest.importorskip('viser')
from setcmas_tools import simulate
from setcmas_tools.view.page.page import Page
from setcmas_tools.view.replay.main import ReplayView
from setcmas_tools.view.replay.options import ReplayOptions


@pytest.fixture
def page():
    served = Page('127.0.0.1', 18980)
    yield served
    served.stop()


def shown(page, **options):
    """Show two runs at a time; returns viser's bodies."""
    runs = {'one': simulate('consensus', 3, 5.0), 'other': simulate('consensus', 3, 8.0, vnom=0.2)}
    view = ReplayView(page, runs, ReplayOptions(**options))
    view.show(4.0)
    view.show(7.0)  # the first one is over
    return view, page.server.scene._handle_from_node_name


def test_ghosts_are_over_the_first_run(page):
    _, bodies = shown(page)

    assert tuple(bodies['/second'].position) == (0, 0, 0)
    assert not bodies['/second/floor'].visible
    assert not bodies['/second/numbers/2'].visible
    assert bodies['/numbers/2'].visible
    own, ghost = (bodies[f'{root}/robots/unicycle/coloured'] for root in ('', '/second'))
    assert ghost.batched_colors[0].min() > own.batched_colors[0].min() + 40  # robot 1 is red


def test_beside_it_has_a_ground_of_its_own(page):
    view, bodies = shown(page, beside=True)
    half_m = view._scene.controls.half_m

    assert tuple(bodies['/second'].position) == pytest.approx((2.35 * half_m, 0, 0))
    assert view._scene.controls.beside_m == 2.35 * half_m
    assert bodies['/second/floor'].visible
    assert bodies['/second/numbers/2'].visible
