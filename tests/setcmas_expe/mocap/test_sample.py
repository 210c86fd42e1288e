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


def drive(V, omega, stamped):
    """Return the estimates along the arc of a robot that drives at (V, omega), 100 a second."""
    estimator = VelocityFilter()
    theta, x, y = 0.3, 0.0, 0.0
    estimates = []
    for step in range(200):
        theta += omega / 100
        x += V * math.cos(theta) / 100
        y += V * math.sin(theta) / 100
        now = 10.0 + step / 100
        turn = (0.0, 0.0, *quaternion_of_yaw(theta))
        sample = Sample((x, y, 0.1), turn, 1e9 + now if stamped else 0.0)
        estimates.append(estimator.update(sample, now))
    return np.array(estimates)


@pytest.mark.parametrize('stamped', [True, False])
@pytest.mark.parametrize(('V', 'omega'), [(0.2, 0.0), (0.2, 1.0), (-0.1, -0.5), (0.0, 2.0)])
def test_velocities_of_a_steady_drive_are_found(V, omega, stamped):
    estimates = drive(V, omega, stamped)

    assert estimates[0].tolist() == [0.0, 0.0]
    assert estimates[-1] == pytest.approx((V, omega), abs=1e-3)
    assert estimates[30][0] == pytest.approx(0.95 * V, abs=0.02)  # after three time constants


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
        (sample(x=9999999.999999, y=9999999.999999), PoseFault.FAR_AWAY),
        (replace(sample(), orientation=(0.0, 0.0, 0.0, 0.0)), PoseFault.NO_ROTATION),
        (replace(sample(), orientation=(0.0, 0.0, 0.0, 0.9)), PoseFault.NO_ROTATION),
        (replace(sample(), orientation=(0.0, 0.0, 0.0, 0.99)), None),
        (replace(sample(), orientation=(1.0, 0.0, 0.0, 0.0)), PoseFault.TILTED),  # on its back
        (replace(sample(), orientation=(0.0, 0.6, 0.0, 0.8)), PoseFault.TILTED),  # wrong y_up
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
