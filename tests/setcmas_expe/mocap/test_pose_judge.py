import math
from dataclasses import replace

import numpy as np
import pytest

from setcmas_expe.mocap.pose_judge import (
    PoseFault,
    PoseJudge,
    VelocityFilter,
    fault_in_words,
    pose_fault,
)
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import ROBOT_LIMITS

RATE = 50.0
NOISE = 1e-4


class Tracker:
    """A track with a clock of its own, fed at the rate of a motion capture system."""

    def __init__(self, seed=0):
        self.track = PoseJudge(Arena(-3, 3, -3, 3), ROBOT_LIMITS['burger'])
        self.now = 1000.0
        self.rng = np.random.default_rng(seed)
        self.paused = False
        self.latency = 0.0
        self.z = 0.1
        self.clock = 5e8  # of the sender, which has nothing to do with ours
        self.stamp = None  # the only one, if there is one

    def feed(self, seconds, x=0.0, y=0.0, yaw=0.0, speed=0.0, noise=NOISE):
        """Feed poses; returns how many of them were good."""
        good = 0
        for step in range(round(seconds * RATE)):
            self.now += 1 / RATE
            dx, dy = self.rng.normal(0, noise, 2) if noise else (0.0, 0.0)
            place = (x + step / RATE * speed + dx, y + dy, self.z)
            stamp = self.stamp or self.clock + self.now - self.latency
            sample = Sample(place, (0.0, 0.0, *quaternion_of_yaw(yaw)), stamp)
            good += self.track.take(sample, self.now, self.paused)
        return good

    def silence(self, seconds):
        self.now += seconds

    def hold_up(self, seconds):
        """Let a network deliver poses that much later from now on."""
        self.silence(seconds)
        self.latency = seconds

    def is_fresh_in_time(self):
        """Return whether poses are fresh once they come in time again."""
        self.latency, self.paused = 0.0, False
        self.feed(0.1)
        return self.age() < 0.01

    def age(self):
        return self.now - self.track.measured


@pytest.fixture
def tracker():
    return Tracker()


def test_poses_of_a_robot_that_drives_are_trusted(tracker):
    assert tracker.age() == math.inf

    assert tracker.feed(5.0, speed=0.21) == 250
    assert tracker.track.fault is None
    assert tracker.track.pose[0] == pytest.approx(5.0 * 0.21, abs=0.01)
    assert tracker.age() == pytest.approx(0.0, abs=1e-6)


def test_a_jump_is_rejected_until_a_pause_while_the_pose_stands_still(tracker):
    tracker.feed(1.0)
    assert tracker.feed(5.0, x=1.0) == 0
    assert tracker.track.fault == PoseFault.JUMPED
    assert 'carried' in tracker.track.trouble

    tracker.paused = True
    assert tracker.feed(0.9, x=1.0) == 0  # not yet
    assert tracker.feed(0.5, x=1.0) > 0

    assert tracker.track.trouble == ''
    assert tracker.track.pose[0] == pytest.approx(1.0, abs=0.01)


def test_a_jump_stays_a_fault_where_no_motion_proves_which_robot_it_is(tracker):
    tracker.track = PoseJudge(Arena(-3, 3, -3, 3), ROBOT_LIMITS['burger'], may_be_carried=False)
    tracker.feed(1.0)
    tracker.paused = True

    assert tracker.feed(10.0, x=1.0) == 0
    assert 'undo that, or restart the experiment' in tracker.track.trouble
    assert tracker.feed(0.5) == 25  # undone


def test_poses_of_a_robot_that_is_carried_are_rejected_even_while_paused(tracker):
    tracker.feed(1.0)
    tracker.paused = True

    assert tracker.feed(2.0, x=1.0, speed=0.5) == 0


def test_single_bad_frames_are_left_out_without_stopping_the_robot(tracker):
    for bad in ({'x': 1.0}, {'yaw': math.pi}, {'x': math.nan, 'noise': 0}) * 7:
        tracker.feed(0.2)
        assert tracker.feed(0.02, **bad) == 0
        assert tracker.track.fault is None


def test_a_late_burst_is_not_a_jump(tracker):
    tracker.feed(1.0, speed=0.2)
    tracker.silence(0.4)

    assert tracker.feed(0.2, x=0.2 + 0.08, speed=0.2) == 10


def test_a_slewed_clock_of_the_sender_is_forgotten_in_a_pause(tracker):
    tracker.feed(2.0)
    tracker.clock -= 0.001
    for _ in range(314):  # by half a second, as fast as chrony slews by default
        tracker.clock -= 0.08 * 0.02
        tracker.feed(0.02)
    assert tracker.age() > 0.4
    tracker.hold_up(0.5)  # by Wi-Fi, meanwhile
    tracker.feed(1.0)

    tracker.latency, tracker.paused = 0.0, True
    tracker.feed(6.0)
    assert tracker.is_fresh_in_time()


@pytest.mark.parametrize('latency', [0.5, 1.0, 2.0])
def test_lateness_counts_as_age_whatever_the_clock_of_the_sender_and_a_pause(tracker, latency):
    tracker.feed(2.0)
    tracker.hold_up(latency)
    tracker.feed(1.0)
    assert tracker.age() == pytest.approx(latency, abs=0.01)
    tracker.paused = True
    tracker.feed(120.0)

    assert tracker.age() == pytest.approx(latency, abs=0.01)
    assert tracker.is_fresh_in_time()


@pytest.mark.parametrize('step', [-3600.0, 3600.0])
def test_setting_the_clock_of_the_sender_is_no_lateness(tracker, step):
    tracker.feed(2.0)
    tracker.clock += step
    tracker.feed(1.0)
    tracker.clock -= step
    tracker.feed(1.0)

    assert tracker.age() < 0.01


def test_setting_the_clock_of_the_sender_back_does_not_make_late_poses_fresh(tracker):
    tracker.feed(2.0)
    tracker.hold_up(0.8)
    tracker.feed(0.5)
    tracker.clock -= 3600.0
    tracker.feed(1.0)

    assert tracker.age() == pytest.approx(0.8, abs=0.02)
    assert tracker.is_fresh_in_time()


def test_a_robot_that_was_lost_cannot_come_back_far_away(tracker):
    tracker.feed(1.0)
    tracker.silence(60.0)

    assert tracker.feed(0.5, x=1.0) == 0
    assert tracker.feed(0.5, x=0.2) == 25


@pytest.mark.parametrize('floor', [0.0, 0.1])
def test_poses_of_a_lifted_robot_are_rejected_until_it_is_set_down(tracker, floor):
    tracker.z = floor
    tracker.feed(1.0)
    tracker.z += 0.1
    assert tracker.feed(0.5) == 0
    text = f'it was lifted (body at {floor + 0.1:.2f} m, usually {floor:.2f})'
    assert text in tracker.track.trouble
    tracker.z = floor
    assert tracker.feed(0.1) == 5

    tracker.z, tracker.paused = floor + 0.1, True  # put onto a box
    assert tracker.feed(1.5) == tracker.feed(1.5, x=1.0) == 0
    tracker.z = floor
    tracker.feed(1.5, x=1.0)
    assert tracker.track.fault is None


def test_a_robot_that_was_in_a_hand_when_it_was_seen_first_may_be_set_down(tracker):
    tracker.z, tracker.paused = 0.8, True
    tracker.feed(1.0)
    tracker.z = 0.1
    assert tracker.feed(0.9) == 0
    tracker.feed(0.5)
    assert tracker.track.fault is None


def test_a_body_that_glides_faster_than_the_robot_jumps_in_the_end(tracker):
    tracker.feed(1.0, speed=0.21)

    good = tracker.feed(0.5, x=0.21, speed=0.5)  # 1 cm from frame to frame
    assert good < 20
    assert tracker.track.fault == PoseFault.JUMPED


@pytest.mark.parametrize('speed', [0.0, 0.2])
def test_constant_stamps_are_reported_as_that(tracker, speed):
    tracker.feed(1.0)
    tracker.stamp = 1e9
    tracker.feed(0.5, speed=speed)

    assert tracker.track.fault == PoseFault.STAMPS
    assert 'its stamps do not change' in tracker.track.trouble
    tracker.stamp = None
    tracker.feed(0.5)
    assert tracker.track.fault is None


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
    assert pose_fault(bad, ARENA) == fault


def test_poses_in_millimetres_are_named_with_numbers_and_units():
    far, in_mm = sample(x=8.0), sample(x=1500.0, y=-700.0)

    assert (
        fault_in_words(PoseFault.FAR_AWAY, far, ARENA)
        == 'at x = 8.0 m, y = 0.2 m, far outside the arena'
    )
    text = fault_in_words(PoseFault.FAR_AWAY, in_mm, ARENA)
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
        assert pose_fault(turned, Arena(-3, 3, -3, 3)) is None
