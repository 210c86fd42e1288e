import math
from dataclasses import replace

import numpy as np
import pytest

from setcmas_expe.mocap.sample import (
    PoseFault,
    Sample,
    VelocityFilter,
    fault_of,
    text_of,
)
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.robots.arena import Arena


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


ARENA = Arena(-2.0, 2.0, -1.0, 1.0)


def sample(x=0.5, y=0.2, yaw=0.3, z=0.1):
    return Sample((x, y, z), (0.0, 0.0, *quaternion_of_yaw(yaw)))


@pytest.mark.parametrize(
    ('bad', 'fault'),
    [
        (sample(), None),
        (sample(x=math.nan), PoseFault.NOT_FINITE),
        (sample(z=math.inf), PoseFault.NOT_FINITE),
        (replace(sample(), orientation=(0.0, 0.0, math.nan, 1.0)), PoseFault.NOT_FINITE),
        (Sample((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)), PoseFault.ZERO),
        (Sample((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)), PoseFault.ZERO),
        (sample(x=0.0, y=0.0), None),  # at the origin, but measured
        (sample(x=9999999.999999, y=9999999.999999), PoseFault.FILLER),
        (replace(sample(), orientation=(0.0, 0.0, 0.0, 0.0)), PoseFault.NO_ROTATION),
        (replace(sample(), orientation=(0.0, 0.0, 0.0, 0.9)), PoseFault.NO_ROTATION),
        (replace(sample(), orientation=(0.0, 0.0, 0.0, 0.99)), None),
        (replace(sample(), orientation=(1.0, 0.0, 0.0, 0.0)), PoseFault.TILTED),  # on its back
        (
            replace(sample(), orientation=(0.0, 0.6, 0.0, 0.8)),
            PoseFault.TILTED,
        ),  # turned, with a wrong y_up
        (replace(sample(), orientation=(0.2, 0.0, 0.0, math.sqrt(0.96))), None),
        (sample(x=2.5), None),  # outside, but to be believed: it must be stopped
        (sample(x=3.5), PoseFault.FAR_AWAY),
        (sample(y=-2.5), PoseFault.FAR_AWAY),
    ],
)
def test_what_is_wrong_with_a_measurement_by_itself(bad, fault):
    assert fault_of(bad, ARENA) == fault


def test_poses_in_millimetres_are_named_with_numbers_and_units():
    far, in_mm = sample(x=8.0), sample(x=1500.0, y=-700.0)

    assert (
        text_of(PoseFault.FAR_AWAY, far, ARENA) == 'at x = 8.0 m, y = 0.2 m, far outside the arena'
    )
    text = text_of(PoseFault.FAR_AWAY, in_mm, ARENA)
    assert text.startswith('at x = 1500.0 m, y = -700.0 m, far outside the arena; does motion')
    assert 'millimetres' in text


def test_y_up_systems_are_turned_with_their_orientation():
    for yaw in np.linspace(-3, 3, 7):
        z, w = quaternion_of_yaw(yaw)
        # The robot at x = 1, y = 2 on the floor, measured by a system with y upwards.
        y_up = Sample((1.0, 0.1, -2.0), (0.0, z, 0.0, w))

        turned = y_up.z_up()

        assert turned.planar() == pytest.approx((1.0, 2.0, yaw))
        assert turned.position[2] == 0.1
        assert fault_of(turned, Arena(-3, 3, -3, 3)) is None
