import pytest

from setcmas_expe.emulation.emulation_options import EmulationOptions, emulated_start_poses
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Arena
from setcmas_simu.simulation_options import StartPoseOptions


@pytest.mark.parametrize('nb_robots', [1, 2, 8, 20])
def test_robots_start_inside_the_arena(nb_robots):
    arena = Arena(-1.0, 3.0, 2.0, 8.0)
    x, y, _ = emulated_start_poses(arena, nb_robots)

    inner = Arena(-0.51, 2.51, 2.49, 7.51)
    assert max(inner.distance(*place) for place in zip(x, y, strict=True)) == 0.0


def test_random_poses_are_inside_the_arena():
    arena = Arena(-1.0, 3.0, 2.0, 8.0)
    x, y, _ = emulated_start_poses(arena, 8, StartPoseOptions(random_poses='auto'))

    assert max(arena.distance(*place) for place in zip(x, y, strict=True)) == 0.0
    with pytest.raises(
        SetcmasError, match='random poses is 5x6 m; it must fit into the arena, 4x6 m'
    ):
        emulated_start_poses(arena, 8, StartPoseOptions(random_poses='box=5x6'))


@pytest.mark.parametrize('model', ['burger', '1:my_robot.py'])
def test_only_a_model_file_moves_emulated_robots(model):
    with pytest.raises(SetcmasError, match='cannot move emulated TurtleBot3s'):
        EmulationOptions(model=model).robot_model([1, 2])
