import numpy as np

from setcmas_ctrl.filter.barrier_constraints import BarrierConstraints

NB_ROBOTS = 30
SPEED = 0.5


def test_omitted_pairs_could_not_hinder_points_of_the_given_speed():
    rng = np.random.default_rng(1)
    points = rng.uniform(-4.0, 4.0, (2, NB_ROBOTS))
    clearance = BarrierConstraints(0.35, 1.5, np.where(np.arange(NB_ROBOTS) < 20, 0.05, 0.0))
    every = clearance.near(points, np.inf)

    near = clearance.near(points, SPEED)

    left_out = np.setdiff1d(every, near)
    assert len(every) == NB_ROBOTS * (NB_ROBOTS - 1) / 2
    assert 0 < len(near) < len(every)
    assert clearance.of_pairs(points, points, left_out).b.min() > 2.0 * SPEED
