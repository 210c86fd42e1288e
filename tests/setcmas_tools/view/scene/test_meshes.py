import numpy as np
import pytest

from setcmas_simu.robots.models import shape_of
from setcmas_simu.robots.unicycle import BURGER_SHAPE
from setcmas_tools.view.scene import meshes, robot_mesh


def volume(mesh):
    """Return the volume that a closed mesh encloses; negative if it is inside out."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]].astype(float) for k in range(3))
    return float((np.cross(a, b) * c).sum() / 6)


@pytest.mark.parametrize(
    ('mesh', 'expected'),
    [
        (meshes.box((0, 1), (0, 2), (0, 3)), 6.0),
        (meshes.cylinder(1.0, 0.0, 2.0, sides=256), 2 * np.pi),
        (meshes.sphere(1.0, sides=256), 4 / 3 * np.pi),
        (meshes.turned_to_x(meshes.cylinder(1.0, 0.0, 2.0, sides=256)), 2 * np.pi),
        (meshes.turned_to_y(meshes.cylinder(1.0, 0.0, 2.0, sides=256)), 2 * np.pi),
    ],
)
def test_bodies_are_closed_and_the_right_side_out(mesh, expected):
    assert volume(mesh) == pytest.approx(expected, rel=1e-3)


def test_a_ring_looks_up():
    ring = meshes.ring(0.9, 1.0, 0.1)
    a, b, c = (ring.vertices[ring.faces[:, k]].astype(float) for k in range(3))

    assert (np.cross(b - a, c - a)[:, 2] >= 0).all()


def test_the_robot_is_as_large_as_a_burger_and_points_ahead():
    both = meshes.merged(
        robot_mesh.coloured_body(BURGER_SHAPE), robot_mesh.dark_body(BURGER_SHAPE)
    )

    assert volume(both) > 0
    assert both.vertices[:, 2].max() == np.float32(BURGER_SHAPE.height)
    assert both.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert np.ptp(both.vertices[:, 1]) == pytest.approx(0.178, abs=0.005)
    nose = both.vertices[both.vertices[:, 0].argmax()]
    assert nose[0] > 0.1
    assert nose[1] == 0.0


@pytest.mark.parametrize('name', ['unicycle', 'burger', 'waffle', 'omnidirectional', 'car'])
def test_every_model_has_closed_bodies_on_the_ground(name):
    shape = shape_of(name)
    bodies = [robot_mesh.coloured_body(shape), robot_mesh.dark_body(shape)]

    assert all(volume(body) > 0 for body in bodies)
    both = meshes.merged(*bodies)
    assert both.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert both.vertices[:, 2].max() == np.float32(shape.height)


def test_scripts_and_unknown_models_look_like_unicycles():
    assert shape_of('my_robot.py') is shape_of('not installed') is BURGER_SHAPE
