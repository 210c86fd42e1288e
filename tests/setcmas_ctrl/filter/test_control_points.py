import numpy as np

from setcmas_ctrl.filter.control_points import along, commands_of_points, velocities_of_points
from setcmas_simu.robots import unicycle

AHEAD, TS = np.full(50, 0.05), 0.2


def test_commands_move_the_point_where_it_is_to_be_after_the_period():
    rng = np.random.default_rng(0)
    poses = np.vstack([rng.uniform(-2, 2, (2, 50)), rng.uniform(-np.pi, np.pi, 50)])
    wanted = 0.2 * along(rng.uniform(-np.pi, np.pi, 50))
    V, _, omega = commands_of_points(wanted, poses[2], AHEAD, TS)

    later, steps = poses, 20_000  # an arc, in small steps
    for _ in range(steps):
        later = unicycle.step(later, V, omega, TS / steps)

    points = poses[:2] + AHEAD * along(poses[2])
    moved = later[:2] + AHEAD * along(later[2]) - points
    np.testing.assert_allclose(moved / TS, wanted, atol=1e-4)


def test_the_velocity_of_a_point_is_that_for_which_the_command_is_given():
    theta = np.linspace(-3, 3, 50)
    wanted = 0.2 * along(3 * theta)

    commands = commands_of_points(wanted, theta, AHEAD, TS)

    np.testing.assert_allclose(velocities_of_points(commands, theta, AHEAD, TS), wanted)
