import math

import msgspec
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from setcmas_tools.page.drawn_markers import MOST_MARKERS, MarkerStore, planar_shape


def marker(kind, points=(), **values):
    message = Marker(type=kind, points=[Point(x=float(x), y=float(y)) for x, y in points])
    message.header.frame_id = 'world'
    message.scale.x = message.scale.y = message.scale.z = 0.5
    message.pose.position.x, message.pose.orientation.w = 2.0, 1.0
    message.color.r = message.color.a = 1.0
    for name, value in values.items():
        setattr(message, name, value)
    return message


def test_a_sphere():
    assert planar_shape(marker(Marker.SPHERE)) == {
        'kind': 'discs',
        'robot': 0,
        'places': [[2.0, 0.0, 0.0]],
        'size': [0.5, 0.5],
        'colours': ['#ff0000'],
        'alpha': 1.0,
    }


def test_a_list_turns_with_its_pose():
    message = marker(Marker.CUBE_LIST, [(1, 0), (0, 1)])
    message.pose.orientation.w = message.pose.orientation.z = math.sqrt(0.5)  # 90 degrees
    found = planar_shape(message)

    assert found['kind'] == 'boxes'
    assert found['places'] == [[2.0, 1.0, 1.5708], [1.0, 0.0, 1.5708]]


def test_every_point_may_have_a_colour():
    colours = [ColorRGBA(r=0.0, g=1.0, b=0.0, a=0.5), ColorRGBA(r=0.0, g=0.0, b=7.0, a=0.5)]
    found = planar_shape(marker(Marker.SPHERE_LIST, [(0, 0), (1, 1)], colors=colours))

    assert (found['colours'], found['alpha']) == (['#00ff00', '#0000ff'], 0.5)


@pytest.mark.parametrize(
    ('kind', 'segments'),
    [(Marker.LINE_STRIP, [[2, 3], [3, 4], [4, 5]]), (Marker.LINE_LIST, [[2, 3], [4, 5]])],
)
def test_lines(kind, segments):
    found = planar_shape(marker(kind, [(x, 0) for x in range(4)]))

    assert found['kind'] == 'lines'
    assert [[place[0], place[2]] for place in found['places']] == segments


def test_an_arrow_between_two_points():
    found = planar_shape(marker(Marker.ARROW, [(0, 0), (0, 3)]))

    assert found['places'] == [[2.0, 0.0, 1.5708]]
    assert found['size'] == [3.0, 0.5]


def test_a_text_and_an_unknown_type():
    text = planar_shape(marker(Marker.TEXT_VIEW_FACING, text='<b>' * 200))

    assert (text['kind'], len(text['text'])) == ('texts', 200)
    assert planar_shape(marker(Marker.MESH_RESOURCE))['kind'] == 'boxes'


@pytest.mark.parametrize('wrong', [math.nan, math.inf])
def test_markers_without_a_finite_place_are_not_shown(wrong):
    message = marker(Marker.SPHERE)
    message.pose.position.y = wrong

    assert planar_shape(message) is None
    assert planar_shape(marker(Marker.LINE_STRIP)) is None
    assert planar_shape(marker(Marker.LINE_STRIP, [(0, 0), (1, wrong)])) is None


def test_a_marker_in_the_frame_of_a_robot():
    message = marker(Marker.CYLINDER)
    message.header.frame_id = 'tb3_3/base_footprint'

    assert planar_shape(message)['robot'] == 3


def test_markers_are_replaced_deleted_and_expire():
    store = MarkerStore()
    store.apply('/a', marker(Marker.SPHERE), 0.0)
    store.apply('/a', marker(Marker.CUBE), 0.0)
    [(name, shape)] = store.take_changes()
    assert (len(store), msgspec.json.decode(shape)['kind']) == (1, 'boxes')
    store.apply('/a', marker(Marker.CUBE), 0.0)
    assert store.take_changes() == []  # nothing is new

    passing = marker(Marker.SPHERE, ns='passing')
    passing.lifetime.sec = 2
    store.apply('/a', passing, 1.0)
    store.expire(2.9)
    assert len(store) == 2
    store.expire(3.0)
    assert len(store) == 1

    store.apply('/b', marker(Marker.SPHERE, action=Marker.DELETE), 3.0)
    assert len(store) == 1
    store.take_changes()
    store.apply('/a', marker(Marker.SPHERE, action=Marker.DELETEALL), 3.0)
    assert store.take_changes() == [(name, None)]


def test_the_number_of_markers_is_bounded():
    store = MarkerStore()
    message = marker(Marker.SPHERE)
    for number in range(MOST_MARKERS + 10):
        message.id = number
        store.apply('/a', message, 0.0)

    assert len(store) == MOST_MARKERS
