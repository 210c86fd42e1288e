import math

import numpy as np
import pytest

from setcmas_expe.mocap.pose_track import (
    FROZEN,
    JUMPED,
    SLOW,
    STAMPS,
    Arrivals,
    PoseTrack,
    mark_swapped,
)
from setcmas_expe.mocap.sample import NOT_FINITE, Sample
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import ROBOT_LIMITS


def came(*gaps):
    arrivals, now = Arrivals(), 5.0
    arrivals.add(now)
    for gap in gaps:
        now += gap
        assert arrivals.add(now) == pytest.approx(gap)
    return arrivals


def test_one_long_gap_is_a_hiccup_and_two_in_a_row_are_a_slow_system():
    assert not came(0.02, 0.02, 0.4, 0.02, 0.4).are_slow
    assert came(0.02, 0.5, 0.5).are_slow
    assert not came(0.5, 0.5, 0.02).are_slow


def test_the_rate_is_that_of_the_usual_gap():
    assert came(0.02, 0.02, 3.0, 0.02).rate == pytest.approx(50.0)
    assert came(0.5, 0.5, 0.5).rate == pytest.approx(2.0)


RATE = 50.0
NOISE = 1e-4


class Tracker:
    """A track with a clock of its own, fed at the rate of a motion capture system."""

    def __init__(self, seed=0):
        self.track = PoseTrack(Arena(-3, 3, -3, 3), ROBOT_LIMITS['burger'])
        self.now = 1000.0
        self.rng = np.random.default_rng(seed)
        self.moving = self.paused = False
        self.latency = 0.0
        self.z = 0.1
        self.clock = 5e8  # of the sender, which has nothing to do with ours
        self.stamp = None  # the only one, if there is one

    def feed(self, seconds, x=0.0, y=0.0, yaw=0.0, speed=0.0, noise=NOISE):
        """Feed poses; returns how many of them were good."""
        good = 0
        for step in range(round(seconds * RATE)):
            self.now += 1 / RATE
            self.track.note_command(self.moving, self.paused, self.now)
            dx, dy = self.rng.normal(0, noise, 2) if noise else (0.0, 0.0)
            place = (x + step / RATE * speed + dx, y + dy, self.z)
            stamp = self.stamp or self.clock + self.now - self.latency
            sample = Sample(place, (0.0, 0.0, *quaternion_of_yaw(yaw)), stamp)
            good += self.track.take(sample, self.now)
        return good

    def silence(self, seconds):
        self.now += seconds
        self.track.note_command(self.moving, self.paused, self.now)


@pytest.fixture
def tracker():
    return Tracker()


def test_poses_of_a_robot_that_drives_are_trusted(tracker):
    assert tracker.track.age(tracker.now) == math.inf
    tracker.moving = True

    assert tracker.feed(5.0, speed=0.21) == 250
    assert tracker.track.fault == ''
    assert tracker.track.pose[0] == pytest.approx(5.0 * 0.21, abs=0.01)
    assert tracker.track.age(tracker.now) == pytest.approx(0.0, abs=1e-6)


def test_a_jump_is_rejected_until_a_pause_while_the_pose_stands_still(tracker):
    tracker.moving = True
    tracker.feed(1.0)
    assert tracker.feed(5.0, x=1.0) == 0
    assert tracker.track.fault == JUMPED
    assert 'carried' in tracker.track.trouble
    assert tracker.track.rejected == {JUMPED: 250}

    tracker.moving, tracker.paused = False, True
    assert tracker.feed(0.9, x=1.0) == 0  # not yet
    assert tracker.feed(0.5, x=1.0) > 0

    assert tracker.track.fault == tracker.track.trouble == ''
    assert tracker.track.pose[0] == pytest.approx(1.0, abs=0.01)


def test_poses_of_a_robot_that_is_carried_are_rejected_even_while_paused(tracker):
    tracker.feed(1.0)
    tracker.paused = True

    assert tracker.feed(2.0, x=1.0, speed=0.5) == 0


def test_single_bad_frames_are_left_out_without_stopping_the_robot(tracker):
    tracker.moving = True
    for _ in range(20):
        tracker.feed(0.2)
        assert tracker.feed(0.02, x=1.0) == 0
        assert tracker.track.fault == ''


@pytest.mark.parametrize(
    ('pose', 'fault'), [({'yaw': math.pi}, JUMPED), ({'x': math.nan, 'noise': 0}, NOT_FINITE)]
)
def test_bad_measurements_are_counted_by_reason(tracker, pose, fault):
    tracker.feed(1.0)

    assert tracker.feed(0.5, **pose) == 0
    assert tracker.track.fault == fault
    assert tracker.track.rejected == {fault: 25}


def test_a_late_burst_is_not_a_jump(tracker):
    tracker.moving = True
    tracker.feed(1.0, speed=0.2)
    tracker.silence(0.4)

    assert tracker.feed(0.2, x=0.2 + 0.08, speed=0.2) == 10


def test_frozen_poses_of_a_robot_that_is_commanded_to_move_are_rejected(tracker):
    tracker.moving = True
    tracker.feed(1.0)
    good = tracker.feed(1.0, noise=0)

    assert good <= 0.45 * RATE
    assert tracker.track.fault == FROZEN
    tracker.moving = False  # it is stopped, and its poses stay frozen
    assert tracker.feed(1.0, noise=0) == 0
    assert tracker.feed(0.1) == 5  # poses change again
    assert tracker.track.fault == ''


def test_a_robot_that_stands_may_have_equal_poses(tracker):
    assert tracker.feed(5.0, noise=0) == 250
    tracker.moving = True

    assert tracker.feed(0.3, noise=0) == 15  # the command to move is recent
    assert tracker.feed(0.3, noise=0) < 10
    assert tracker.track.fault == FROZEN


def test_a_pause_gives_frozen_poses_another_try(tracker):
    tracker.moving = True
    tracker.feed(1.0, noise=0)
    tracker.moving, tracker.paused = False, True

    assert tracker.feed(0.2, noise=0) == 10


def test_lateness_counts_as_age_whatever_the_clock_of_the_sender(tracker):
    tracker.feed(2.0)
    tracker.silence(0.8)
    tracker.latency = 0.8
    tracker.feed(1.0)

    assert tracker.track.age(tracker.now) == pytest.approx(0.8, abs=0.01)
    tracker.latency = 0.0
    tracker.feed(0.1)
    assert tracker.track.age(tracker.now) < 0.01


@pytest.mark.parametrize('step', [-3600.0, 3600.0])
def test_setting_the_clock_of_the_sender_is_no_lateness(tracker, step):
    tracker.feed(2.0)
    tracker.clock += step
    tracker.feed(1.0)
    tracker.clock -= step
    tracker.feed(1.0)

    assert tracker.track.age(tracker.now) < 0.01


def swapped_trackers():
    one, two = Tracker(1), Tracker(2)
    tracks = {1: one.track, 2: two.track}
    one.feed(1.0, x=1.0)
    two.feed(1.0, x=-1.0)
    one.feed(0.3, x=-1.0)
    two.feed(0.3, x=1.0)
    assert mark_swapped(tracks) == [1, 2]
    return one, two, tracks


def test_swapped_names_are_recognised_and_not_taken_for_carried_robots():
    one, two, tracks = swapped_trackers()
    assert mark_swapped(tracks) == []  # only once
    assert 'swapped places with robot 2' in one.track.trouble
    for tracker, x in ((one, -1.0), (two, 1.0)):
        tracker.paused = True
        assert tracker.feed(3.0, x=x) == 0


def test_three_names_that_moved_up_during_a_pause_are_recognised():
    trackers = {number: Tracker(number) for number in (1, 2, 3)}
    places = (-2.0, 0.0, 2.0)
    for number, tracker in trackers.items():
        tracker.paused = True
        tracker.feed(1.0, x=places[number - 1])
    for number, tracker in trackers.items():
        tracker.feed(0.3, x=places[number % 3])
    tracks = {number: tracker.track for number, tracker in trackers.items()}

    assert mark_swapped(tracks) == [1, 2, 3]
    assert 'swapped places with robot 1' in trackers[3].track.trouble
    assert all(t.feed(3.0, x=places[n % 3]) == 0 for n, t in trackers.items())


def test_swapped_names_that_are_put_right_are_forgiven():
    one, two, _ = swapped_trackers()

    assert one.feed(0.1, x=1.0) == two.feed(0.1, x=-1.0) == 5
    assert one.track.trouble == two.track.trouble == ''


def test_a_robot_that_jumped_alone_is_not_swapped():
    one, two = Tracker(1), Tracker(2)
    for tracker, x in ((one, 1.0), (two, -1.0)):
        tracker.feed(1.0, x=x)
    one.feed(0.5, x=-1.0)

    assert mark_swapped({1: one.track, 2: two.track}) == []


def test_a_robot_that_was_lost_cannot_come_back_far_away(tracker):
    tracker.feed(1.0)
    tracker.silence(60.0)

    assert tracker.feed(0.5, x=1.0) == 0
    assert tracker.feed(0.5, x=0.2) == 25


def test_two_poses_a_second_are_too_few(tracker):
    tracker.feed(1.0)
    for _ in range(2):
        tracker.silence(0.48)
        tracker.feed(0.02)

    assert SLOW in tracker.track.rejected


def test_a_lifted_robot_is_found_where_the_usual_height_is_exactly_zero(tracker):
    tracker.z = 0.0
    tracker.feed(1.0)
    tracker.z, tracker.paused = 0.2, True
    assert tracker.feed(1.5) == 0


def test_poses_of_a_lifted_robot_are_rejected_until_it_is_set_down(tracker):
    tracker.feed(1.0)
    tracker.z = 0.2
    assert tracker.feed(0.5) == 0
    assert 'it was lifted (body at 0.20 m, usually 0.10)' in tracker.track.trouble
    tracker.z = 0.1
    assert tracker.feed(0.1) == 5

    tracker.z, tracker.paused = 0.2, True  # put onto a box
    assert tracker.feed(1.5) == tracker.feed(1.5, x=1.0) == 0
    tracker.z = 0.1
    tracker.feed(1.5, x=1.0)
    assert tracker.track.fault == ''


def test_a_robot_that_was_in_a_hand_when_it_was_seen_first_may_be_set_down(tracker):
    tracker.z, tracker.paused = 0.8, True
    tracker.feed(1.0)
    tracker.z = 0.1
    assert tracker.feed(0.9) == 0
    tracker.feed(0.5)
    assert tracker.track.fault == ''


def test_a_body_that_glides_faster_than_the_robot_jumps_in_the_end(tracker):
    tracker.moving = True
    tracker.feed(1.0, speed=0.21)

    good = tracker.feed(0.5, x=0.21, speed=0.5)  # 1 cm from frame to frame
    assert good < 20
    assert tracker.track.fault == JUMPED


@pytest.mark.parametrize('speed', [0.0, 0.2])
def test_constant_stamps_are_reported_as_that(tracker, speed):
    tracker.feed(1.0)
    tracker.stamp = 1e9
    tracker.feed(0.5, speed=speed)

    assert tracker.track.fault == STAMPS
    assert 'its stamps do not change' in tracker.track.trouble
    tracker.stamp = None
    tracker.feed(0.5)
    assert tracker.track.fault == ''
