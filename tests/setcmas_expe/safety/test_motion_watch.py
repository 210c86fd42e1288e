import math

import pytest

from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_expe.mocap.pose_track import PoseTrack
from setcmas_expe.mocap.sample import Sample
from setcmas_expe.safety.body_proofs import Proofs
from setcmas_expe.safety.motion_watch import MotionWatch
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw

LAB = load_lab(DEFAULT_FILE, 2)
STEP_S = 0.05


class Fleet:
    """Two robots that want to go ahead side by side, and the watch over them."""

    def __init__(self, file, bodies=(1, 2)):
        self.told = []
        self.proofs = Proofs(LAB, file)
        self.tracks = {robot: PoseTrack(LAB.arena, LAB.limits) for robot in (1, 2)}
        self.watch = MotionWatch((1, 2), self.proofs, self.told.append)
        self.now = 10.0
        self.x = {1: -1.0, 2: -1.0}
        self.bodies = bodies  # what motion capture takes each robot for
        self.fastest = 0.0
        self.slip = 0.0  # share of the way that wheels lose

    def drive(self, seconds, V=0.2):
        for _ in range(round(seconds / STEP_S)):
            self.now += STEP_S
            for robot, body in zip((1, 2), self.bodies, strict=True):
                place = (self.x[robot], 1.0 * robot + 1e-5 * math.sin(self.now), 0.1)
                sample = Sample(place, (0.0, 0.0, *quaternion_of_yaw(0.0)))
                self.tracks[body].take(sample, self.now)
            self.watch.see(self.tracks, {1: None, 2: None}, self.now)
            if any(map(self.watch.trouble, (1, 2))):
                return
            commands = {robot: self.watch.allowed(robot, V, 0.0) for robot in (1, 2)}
            self.watch.commanded(commands, self.now)
            for robot, (speed, _) in commands.items():
                self.x[robot] += (1.0 - self.slip) * speed * STEP_S
                self.fastest = max(self.fastest, speed)


@pytest.fixture
def file(tmp_path):
    return tmp_path / 'proved.yaml'


def test_robots_crawl_until_they_are_proved_and_the_next_time_they_do_not(file):
    fleet = Fleet(file)
    fleet.drive(1.9)
    assert fleet.fastest == pytest.approx(0.05)
    fleet.drive(3.0)

    assert fleet.fastest == pytest.approx(0.2)
    assert fleet.told[0].startswith('robots 1-2 crawl at 0.05 m/s for 10 cm, in turns')
    assert sorted(fleet.told[1:]) == [f'robot {i} is proved by motion: full speed' for i in (1, 2)]
    again = Fleet(file)
    again.drive(0.2)
    assert again.fastest == pytest.approx(0.2)
    assert again.told == []


def test_commands_without_seen_motion_prove_nothing(file):
    fleet = Fleet(file)
    fleet.slip = 0.3  # which is not enough to doubt it
    fleet.drive(4.6)

    assert max(fleet.x.values()) > -1.0 + 0.07
    assert fleet.proofs.proved() == []
    assert not any(map(fleet.watch.trouble, (1, 2)))


def test_exchanged_names_are_reported_before_robots_have_gone_far(file):
    fleet = Fleet(file, bodies=(2, 1))
    fleet.drive(5.0)

    troubles = {fleet.watch.trouble(robot) for robot in (1, 2)} - {''}
    assert troubles <= {f'moves as robot {i} should: are their names exchanged?' for i in (1, 2)}
    assert troubles
    assert max(fleet.x.values()) < -1.0 + 0.04


def test_a_robot_that_deviates_is_proved_no_more(file):
    fleet = Fleet(file)
    fleet.drive(6.0)
    assert fleet.proofs.proved() == [1, 2]
    begin, stuck = fleet.now, fleet.x[1]
    while not fleet.watch.trouble(1):
        fleet.x[1] = stuck
        fleet.drive(STEP_S)
        assert fleet.now < begin + 0.7

    assert 'does not move as commanded' in fleet.watch.trouble(1)
    assert fleet.proofs.proved() == [2]
    fleet.watch.commanded({}, fleet.now)  # somebody has paused
    assert fleet.watch.trouble(1) == ''
    assert fleet.watch.allowed(1, 0.2, 0.0)[0] <= 0.05
