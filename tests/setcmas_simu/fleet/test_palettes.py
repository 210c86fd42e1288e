import numpy as np

from setcmas_simu.fleet.palettes import colour, plot_colour, plot_hex


def test_the_ninth_robot_has_the_colour_of_the_first_in_a_small_fleet():
    assert colour(9) == colour(1) == plot_colour(9, 16)
    assert plot_hex(9, 16) == '#0072b2'


# G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, IEEE TVCG 15(6), 2009: deuteranopia.
SEEN = [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]


def least_difference():
    linear = np.array([colour(robot) for robot in range(1, 9)]) ** 2.2
    seen = np.clip(linear @ np.transpose(SEEN), 0, 1) ** (1 / 2.2)
    differences = np.linalg.norm(seen[:, None] - seen, axis=2)
    return differences[np.triu_indices(8, 1)].min()


def test_colour_blind_readers_can_tell_eight_robots_apart():
    assert least_difference() > 0.18


def test_a_large_fleet_has_a_scale_of_colours():
    found = [plot_colour(robot, 50) for robot in range(1, 51)]

    assert len(set(found)) == 50
    assert (np.diff([sum(one) for one in found]) > 0).all()
