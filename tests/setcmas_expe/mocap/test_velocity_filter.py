import math

import numpy as np
import pytest

from setcmas_expe.mocap.sample import Sample
from setcmas_expe.mocap.velocity_filter import VelocityFilter
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw


def drive(V, omega, seconds=2.0, rate=100.0, noise=0.0, stamped=True, back=0.0):
    """Return the estimates along the arc of a robot that drives at (V, omega)."""
    rng = np.random.default_rng(0)
    estimator = VelocityFilter()
    theta, x, y = 0.3, 0.0, 0.0
    estimates = []
    for step in range(round(seconds * rate)):
        theta += omega / rate
        x += V * math.cos(theta) / rate
        y += V * math.sin(theta) / rate
        dx, dy = rng.normal(0, noise, 2) if noise else (0.0, 0.0)
        now = 10.0 + step / rate
        stamp = 1e9 + now - (back if now > 11.5 else 0.0)
        sample = Sample(
            (x + dx, y + dy, 0.1),
            (0.0, 0.0, *quaternion_of_yaw(theta)),
            stamp if stamped else 0.0,
        )
        estimates.append(estimator.update(sample, now))
    return np.array(estimates)


@pytest.mark.parametrize('stamped', [True, False])
@pytest.mark.parametrize(('V', 'omega'), [(0.2, 0.0), (0.2, 1.0), (-0.1, -0.5), (0.0, 2.0)])
def test_velocities_of_a_steady_drive_are_found(V, omega, stamped):
    estimates = drive(V, omega, stamped=stamped)

    assert estimates[0].tolist() == [0.0, 0.0]
    assert estimates[-1] == pytest.approx((V, omega), abs=1e-3)
    assert estimates[30][0] == pytest.approx(0.95 * V, abs=0.02)  # after three time constants


def test_noise_is_smoothed():
    assert drive(0.2, 0.0, noise=1e-4)[50:, 0].std() < 0.3 * math.sqrt(2) * 1e-4 * 100


def test_a_clock_that_is_set_disturbs_but_for_a_moment():
    estimates = drive(0.2, 0.0, back=3600.0, seconds=3.0)

    assert np.abs(estimates[:, 0]).max() < 0.21
    assert estimates[-1][0] == pytest.approx(0.2, abs=1e-3)
