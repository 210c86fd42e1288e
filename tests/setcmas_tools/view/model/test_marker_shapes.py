import numpy as np
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from setcmas_simu.robots.models import shape_of
from setcmas_simu.simulator.virtual_robot import robot_marker
from setcmas_tools.view.model import marker_shapes
from setcmas_tools.view.model.marker_shapes import LABEL, LINES, shape
from setcmas_tools.view.model.marker_store import MOST_MARKERS, MarkerStore


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
    found = shape(marker(Marker.SPHERE))

    assert (found.kind, found.robot) == ('sphere', 0)
    np.testing.assert_allclose(found.rows, [[2, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0.5, 1, 0, 0, 1]])


def test_a_list_turns_with_its_pose():
    message = marker(Marker.CUBE_LIST, [(1, 0), (0, 1)])
    message.pose.orientation.w = message.pose.orientation.z = 1.0  # 90 degrees, not normalised

    found = shape(message)

    assert found.kind == 'cube'
    np.testing.assert_allclose(found.rows[:, :2], [(2, 1), (1, 0)], atol=1e-12)


def test_every_point_may_have_a_colour():
    colours = [ColorRGBA(r=0.0, g=1.0, b=0.0, a=1.0), ColorRGBA(r=0.0, g=0.0, b=1.0, a=0.5)]
    found = shape(marker(Marker.SPHERE_LIST, [(0, 0), (1, 1)], colors=colours))

    np.testing.assert_allclose(found.rows[:, 10:], [(0, 1, 0, 1), (0, 0, 1, 0.5)])


@pytest.mark.parametrize(
    ('kind', 'segments'),
    [(Marker.LINE_STRIP, [[2, 3], [3, 4], [4, 5]]), (Marker.LINE_LIST, [[2, 3], [4, 5]])],
)
def test_lines(kind, segments):
    found = shape(marker(kind, [(x, 0) for x in range(4)]))

    assert found.kind == LINES
    assert found.rows[:, [0, 3]].tolist() == segments
    assert found.thickness == 0.5


def test_an_arrow_between_two_points_lies_along_them():
    found = shape(marker(Marker.ARROW, [(0, 0), (0, 3)]))
    tip = found.rows[0, :3] + marker_shapes.rotate(found.rows[0, 3:7], np.array([[3.0, 0, 0]]))

    assert found.rows[0, 7] == 3.0
    np.testing.assert_allclose(tip, [[2, 3, 0]], atol=1e-12)


def test_a_text():
    found = shape(marker(Marker.TEXT_VIEW_FACING, text='goal'))

    assert (found.kind, found.text) == (LABEL, 'goal')


def test_what_is_not_known_is_shown_as_a_cube():
    found = shape(marker(Marker.MESH_RESOURCE))

    assert found.kind == 'cube'
    assert found.rows[0, 0] == 2.0


def test_what_is_not_finite_is_not_shown():
    message = marker(Marker.SPHERE)
    message.pose.position.y = float('nan')

    assert shape(message) is None


def test_a_marker_in_a_robots_frame_moves_with_it():
    store = MarkerStore()
    message = marker(Marker.CYLINDER)
    message.header.frame_id = 'tb3_3/base_footprint'
    store.apply('/arena', message, 0.0)

    assert store.moves('cylinder')
    rows = store.solids('cylinder', {3: (1.0, 1.0, np.pi / 2)})
    np.testing.assert_allclose(rows[0, :3], (1, 3, 0), atol=1e-12)
    np.testing.assert_allclose(rows[0, 3:7], (np.sqrt(0.5), 0, 0, np.sqrt(0.5)), atol=1e-12)
    assert not len(store.solids('cylinder', {}))


def test_markers_are_replaced_deleted_and_expire():
    store = MarkerStore()
    store.apply('/a', marker(Marker.SPHERE), 0.0)
    store.apply('/a', marker(Marker.CUBE), 0.0)
    assert len(store) == 1
    assert store.changed == {'sphere', 'cube'}

    passing = marker(Marker.SPHERE, ns='passing')
    passing.lifetime.sec = 2
    store.apply('/a', passing, 1.0)
    store.expire(2.9)
    assert len(store) == 2
    store.expire(3.0)
    assert len(store) == 1

    store.apply('/b', marker(Marker.SPHERE, action=Marker.DELETE), 3.0)
    assert len(store) == 1
    store.apply('/a', marker(Marker.SPHERE, action=Marker.DELETEALL), 3.0)
    assert len(store) == 0


def test_the_number_of_markers_is_bounded():
    store = MarkerStore()
    message = marker(Marker.SPHERE)
    for number in range(MOST_MARKERS + 10):
        message.id = number
        store.apply('/a', message, 0.0)

    assert len(store) == MOST_MARKERS


def test_the_robots_own_marker_has_all_its_cubes():
    assert len(shape(robot_marker(1)).rows) == 5


def test_other_models_are_drawn_with_their_parts():
    car = robot_marker(1, shape=shape_of('car'))

    assert shape(car) is not None
    assert len(car.points) % 3 == 0
    assert max(point.x for point in car.points) == max(x for x, _ in shape_of('car').outline)
