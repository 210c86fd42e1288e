import itertools
import math

import pytest

from setcmas_expe.bridge.bridge_decision import RobotView
from setcmas_expe.bridge.motion_watch import (
    CRAWL_M_S,
    PROOF_M,
    PROOF_RAD,
    SLOW_TURN_RAD_S,
    MotionWatch,
    Proving,
)
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_expe.mocap.pose_judge import PoseJudge
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw

LAB = load_lab(DEFAULT_FILE, 2)
STEP_S = 0.05


class Fleet:
    """Two robots that want to go ahead side by side, and the watch over them."""

    def __init__(self, bodies=(1, 2)):
        self.warnings = []
        self.tracks = {robot: PoseJudge(LAB.arena, LAB.limits) for robot in (1, 2)}
        self.paused = True
        self.watch = MotionWatch((1, 2), self.warnings.append, self.warnings.append)
        self.now = 10.0
        self.x = {1: -1.0, 2: -1.0}
        self.bodies = bodies  # what motion capture takes each robot for
        self.fastest = 0.0
        self.slip = 0.0  # share of the way that wheels lose
        self.hidden = False
        self.heights = {1: 0.1, 2: 0.1}

    @property
    def proved(self):
        return [robot for robot in (1, 2) if self.watch.is_proved(robot)]

    def pause(self, seconds):
        self.paused = True
        for _ in range(round(seconds / STEP_S)):
            self.look()
            self.watch.commanded({}, self.now)

    def look(self):
        self.now += STEP_S
        self._capture()
        views = {robot: view_of(robot, track) for robot, track in self.tracks.items()}
        self.watch.see(views, self.now)

    def _capture(self):
        for robot, body in zip((1, 2), self.bodies, strict=True):
            height = self.heights[robot]
            place = (self.x[robot], 1.0 * robot + 1e-5 * math.sin(self.now), height)
            sample = Sample(place, (0.0, 0.0, *quaternion_of_yaw(0.0)))
            if not self.hidden:
                self.tracks[body].take(sample, self.now, self.paused)

    def drive(self, seconds, V=0.2, omega=0.0):
        self.paused = False
        for _ in range(round(seconds / STEP_S)):
            self.look()
            if self.watch.deviations():
                return
            commands = {robot: self.watch.proving.allowed(robot, V, omega) for robot in (1, 2)}
            self.watch.commanded(commands, self.now)
            for robot, (speed, _) in commands.items():
                self.x[robot] += (1.0 - self.slip) * speed * STEP_S
                self.fastest = max(self.fastest, speed)


def view_of(robot, track):
    """Return what a bridge knows of a robot whose poses differ from frame to frame."""
    height = math.nan if track.height is None else track.height
    seen = track.measured
    return RobotView(robot, track.pose, seen, seen, seen, pose_fault=track.trouble, height=height)


def test_robots_crawl_until_they_are_proved_and_not_after_a_pause():
    fleet = Fleet()
    fleet.drive(1.9)
    assert fleet.fastest == pytest.approx(0.05)
    fleet.drive(3.0)

    assert fleet.fastest == pytest.approx(0.2)
    assert fleet.warnings[0].startswith('robots 1-2: 10 cm at a crawl')
    assert sorted(fleet.warnings[1:]) == [
        f'robot {i} is identified by motion: full speed' for i in (1, 2)
    ]
    fleet.pause(5.0)
    fleet.x[1] += 0.05  # a person pushes it a little
    fleet.pause(1.0)
    assert fleet.proved == [1, 2]


def carry(fleet):
    fleet.x[1] += 0.3


def push_slowly(fleet):
    for _ in range(30):
        fleet.x[1] += 0.01
        fleet.pause(STEP_S)


def hide(fleet):
    fleet.hidden = True
    fleet.pause(1.2)
    fleet.hidden = False


@pytest.mark.parametrize(('change', 'proved'), [(carry, [2]), (push_slowly, [2]), (hide, [])])
def test_a_proof_ends_when_another_body_may_have_got_the_name(change, proved):
    fleet = Fleet()
    fleet.drive(6.0)
    fleet.pause(1.5)
    assert fleet.proved == [1, 2]
    change(fleet)
    fleet.pause(1.5)
    assert fleet.proved == proved
    fleet.fastest = 0.0
    assert fleet.watch.proving.allowed(1, 0.2, 0.0)[0] <= 0.05

    fleet.drive(6.0)
    assert fleet.proved == [1, 2]


def test_a_stop_of_this_process_ends_all_proofs_though_its_clock_stood_still():
    fleet = Fleet()
    fleet.drive(6.0)
    fleet.pause(0.1)
    fleet.watch.end_proofs()  # asleep with the laptop, while bodies were exchanged
    fleet.pause(3.0)
    assert fleet.proved == []
    fleet.drive(0.5)
    assert len([line for line in fleet.warnings if 'crawl' in line]) == 2


def test_a_body_that_settles_elsewhere_is_proved_again():
    fleet = Fleet()
    fleet.drive(6.0)
    fleet.now += 0.02
    fleet._capture()  # between two looks
    carry(fleet)  # before the place where it rests was noted
    fleet.now -= 0.02
    fleet.pause(1.5)

    assert fleet.proved == [2]


def test_a_robot_that_has_proved_its_way_is_not_judged_as_one_that_crawls():
    fleet = Fleet()
    fleet.drive(6.0)
    fleet.drive(1.0, V=0.0)
    fleet.x[1] += 0.025
    fleet.drive(1.0, V=0.0)

    assert 1 not in fleet.watch.deviations()


def test_a_slow_turn_soon_shows_that_motion_capture_sees_no_turning():
    fleet = Fleet()
    fleet.drive(6.0)
    begin = fleet.now
    fleet.drive(3.0, V=0.0, omega=2.0)

    assert fleet.now - begin < 1.2
    assert 'is y_up wrong' in fleet.watch.deviations()[1]


def test_half_a_proof_ends_too():
    fleet = Fleet()
    fleet.drive(4.0)  # robot 2 is proved, robot 1 has 2 cm left
    fleet.pause(1.5)
    carry(fleet)
    fleet.pause(1.5)
    fleet.drive(1.0)

    assert fleet.proved == [2]


def test_bodies_that_are_exchanged_during_a_pause_are_found_by_the_next_crawl():
    fleet = Fleet()
    fleet.drive(6.0)
    fleet.pause(1.5)
    fleet.hidden = True
    fleet.pause(2.0)
    fleet.hidden, fleet.bodies = False, (2, 1)
    fleet.tracks = {robot: PoseJudge(LAB.arena, LAB.limits) for robot in (1, 2)}  # as settled
    fleet.pause(1.5)
    begin = dict(fleet.x)
    fleet.drive(5.0)

    troubles = set(fleet.watch.deviations().values())
    assert any('are their names swapped?' in trouble for trouble in troubles)
    assert max(fleet.x[robot] - begin[robot] for robot in (1, 2)) < 0.04


def test_bodies_at_very_different_heights_are_not_on_one_floor():
    fleet = Fleet()
    fleet.heights[2] = -1.4  # y, where y_up is wrong
    fleet.look()

    for robot in (1, 2):
        assert 'heights from -1.40 to 0.10 m: is y_up wrong' in fleet.watch.deviations()[robot]


def test_commands_without_seen_motion_prove_nothing():
    fleet = Fleet()
    fleet.slip = 0.3  # which is not enough to doubt it
    fleet.drive(4.6)

    assert max(fleet.x.values()) > -1.0 + 0.07
    assert fleet.proved == []
    assert not fleet.watch.deviations()


def test_when_a_robot_deviates_all_must_prove_themselves_again():
    fleet = Fleet()
    fleet.drive(6.0)
    assert fleet.proved == [1, 2]
    begin, stuck = fleet.now, fleet.x[1]
    while 1 not in fleet.watch.deviations():
        fleet.x[1] = stuck
        fleet.drive(STEP_S)
        assert fleet.now < begin + 0.7

    assert 'does not move as commanded' in fleet.watch.deviations()[1]
    assert fleet.proved == []
    fleet.watch.commanded({}, fleet.now)  # a person has paused
    assert not fleet.watch.deviations()
    assert fleet.watch.proving.allowed(1, 0.2, 0.0)[0] <= 0.05


def turns(nb_robots, seconds=12.0, step=0.05):
    """Return for each robot when it may move."""
    proving = Proving(range(1, nb_robots + 1))
    moves = {robot: [] for robot in range(1, nb_robots + 1)}
    for _ in range(round(seconds / step)):
        for robot, may in moves.items():
            may.append(proving.allowed(robot, 0.2, 0.0)[0] > 0)
        proving.go_on(step)
    return moves


@pytest.mark.parametrize('nb_robots', [2, 3, 8, 50])
def test_any_two_robots_move_at_different_times_and_each_as_long(nb_robots):
    moves = turns(nb_robots)

    for one, other in itertools.combinations(moves, 2):
        alone = sum(a and not b for a, b in zip(moves[one], moves[other], strict=True))
        assert alone * 0.05 >= 0.6
    assert all(sum(may) * 0.05 * CRAWL_M_S >= PROOF_M - 0.01 for may in moves.values())


def test_one_robot_crawls_without_a_break_until_it_is_proved():
    proving = Proving([1])

    assert proving.allowed(1, 0.2, 0.4) == pytest.approx((CRAWL_M_S, 0.1))
    assert not proving.went(1, 0.06, PROOF_RAD)
    assert not proving.went(1, -0.03, 0.0)
    assert proving.went(1, 0.08, 0.0)
    assert proving.allowed(1, 0.2, 0.4) == (0.2, 0.4)
    proving.end(1)
    assert proving.allowed(1, 0.2, 0.0) == (CRAWL_M_S, 0.0)


def test_a_robot_turns_slowly_on_its_curve_until_its_turning_is_proved_and_drives_straight_fast():
    proving = Proving([1])
    assert proving.went(1, PROOF_M, 0.0)
    assert proving.allowed(1, 0.2, 0.0) == (0.2, 0.0)
    assert proving.allowed(1, 0.2, -SLOW_TURN_RAD_S) == (0.2, -SLOW_TURN_RAD_S)
    assert proving.allowed(1, 0.2, 1.5) == pytest.approx((0.2 * SLOW_TURN_RAD_S / 1.5, 0.3))
    proving.went(1, 0.5, -2 * PROOF_RAD)  # no debt
    proving.went(1, 0.5, 0.9 * PROOF_RAD)
    proving.went(1, 0.5, -0.3 * PROOF_RAD)
    assert proving.allowed(1, 0.0, 2.0)[1] == pytest.approx(SLOW_TURN_RAD_S)
    proving.went(1, 0.0, 0.4 * PROOF_RAD)
    assert proving.allowed(1, 0.2, 1.5) == (0.2, 1.5)
    proving.end(1)
    assert proving.allowed(1, 0.0, 1.5) == pytest.approx((0.0, SLOW_TURN_RAD_S))
