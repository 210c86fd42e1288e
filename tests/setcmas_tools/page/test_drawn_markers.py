import math

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker

from setcmas_tools.page import drawn_markers
from setcmas_tools.page.drawn_markers import MarkerStore, planar_shape


def marker(kind, points=(), **fields):
    message = Marker(type=kind, **fields)
    message.pose.position.x, message.pose.position.y = 2.0, 3.0
    message.scale.x = message.scale.y = 0.4
    message.color.r = message.color.a = 1.0
    message.points = [Point(x=float(x), y=float(y)) for x, y in points]
    return message


@pytest.mark.parametrize('kind', [Marker.SPHERE, Marker.CYLINDER])
def test_a_disc(kind):
    assert planar_shape(marker(kind)) == {
        'kind': 'discs',
        'robot': 0,
        'places': [[2.0, 3.0]],
        'size': 0.4,
        'colour': '#ff0000',
        'alpha': 1.0,
    }


def test_an_outline():
    found = planar_shape(marker(Marker.LINE_STRIP, [(0, 0), (1, 0), (1, 2)]))

    assert (found['kind'], found['places']) == ('lines', [[0, 0, 1, 0], [1, 0, 1, 2]])


@pytest.mark.parametrize('wrong', [math.nan, math.inf])
def test_markers_without_a_finite_place_and_of_other_kinds_are_not_shown(wrong):
    message = marker(Marker.SPHERE)
    message.pose.position.x = wrong

    assert planar_shape(message) is None
    assert planar_shape(marker(Marker.LINE_STRIP)) is None
    assert planar_shape(marker(Marker.LINE_STRIP, [(0, 0), (1, wrong)])) is None
    assert planar_shape(marker(Marker.CUBE)) is None


def test_markers_are_replaced_and_go_with_their_topic():
    store = MarkerStore()
    store.put('/a', marker(Marker.SPHERE))
    store.put('/b', marker(Marker.CYLINDER))
    assert [name for name, _ in store.take_changes()] == ['/a\0\x000', '/b\0\x000']

    store.put('/a', marker(Marker.SPHERE))
    assert store.take_changes() == []
    store.put('/a', marker(Marker.CYLINDER, id=1))
    store.drop_topics({'/a'})
    assert sorted(store.take_changes()) == [('/a\0\x000', None), ('/a\0\x001', None)]
    assert len(store) == 1


def test_the_number_of_markers_is_bounded(monkeypatch):
    monkeypatch.setattr(drawn_markers, 'MOST_MARKERS', 3)
    store = MarkerStore()
    for number in range(5):
        store.put('/a', marker(Marker.SPHERE, id=number))

    assert len(store) == 3
    gone = [found is None for _, found in store.take_changes()]
    assert gone == [True] * 2 + [False] * 3
