import operator
from dataclasses import replace

import numpy as np
import pytest
from identified_robots import TRUTH, assert_found

from launch_scripts.cli import main
from setcmas_ctrl.si_to_uni import si_to_uni
from setcmas_simu.robots.identified_robot import Response
from setcmas_tools import simulate
from setcmas_tools.measures.comparison import best_shift
from setcmas_tools.measures.identification import (
    FORWARD,
    TURN,
    Identified,
    identified_notes,
    limits_of,
    recorded_commands,
)
from setcmas_tools.measures.response_fit import Fit
from setcmas_tools.run.run import Run

ODOMETRY, TWIST = 'nav_msgs/msg/Odometry', 'geometry_msgs/msg/TwistStamped'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'truth.yaml').write_text(TRUTH)
    return tmp_path


def noisy(run):
    """The run as motion capture would have seen it."""
    rng, table = np.random.default_rng(3), run.table
    wrong = {
        name: getattr(table, name) + rng.normal(0.0, sigma, len(table.t))
        for name, sigma in (('x', 2e-4), ('y', 2e-4), ('theta', 2e-3))
    }
    return replace(run, table=replace(table, **wrong))


SLOW = {'vnom': 0.1, 'komega': 0.5, 'set': {'WPL': [[4.8, 4.9], [4.9, -4.8]]}}
"""Too slow for limits: then the recorded commands are those that robots follow."""


@pytest.fixture
def record(make, write_bag):
    """A function that writes the bag of a run: odometry and the commands of its robots."""

    def record(run, folder):
        messages = []
        for robot in run.robots:
            track, law = run.table.of(robot), run.commands.of(robot)
            for t, x, y, theta in zip(track.t, track.x, track.y, track.theta, strict=True):
                pose = {'position.x': x, 'position.y': y}
                pose |= {'orientation.z': np.sin(theta / 2), 'orientation.w': np.cos(theta / 2)}
                known = {f'pose.pose.{name}': value for name, value in pose.items()}
                messages.append((f'/tb3_{robot}/odom', t, make(ODOMETRY, known)))
            headings = np.interp(law.t, track.t, np.unwrap(track.theta))
            for t, vx, vy, theta in zip(law.t, law.vx, law.vy, headings, strict=True):
                V, omega = si_to_uni((vx, vy), theta, SLOW['komega'])
                twist = {'twist.linear.x': V, 'twist.angular.z': omega}
                messages.append((f'/tb3_{robot}/cmd_vel', t, make(TWIST, twist)))
        return write_bag(folder, sorted(messages, key=operator.itemgetter(1)))

    return record


@pytest.mark.nightly
def test_the_next_simulation_is_nearer_to_what_was_measured(folder, record, capsys):
    run = noisy(simulate('nav_wp', 2, 60.0, model='truth.yaml', robot_rate=50.0, **SLOW))
    record(run, folder / 'bag')

    assert main(['identify', 'bag', '-o', 'found.yaml']) == 0

    assert_found('found.yaml')
    printed = capsys.readouterr().out.split()
    assert printed[-1] == 'found.yaml'
    nearer = simulate('nav_wp', 2, 60.0, model='found.yaml', **SLOW)
    before = simulate('nav_wp', 2, 60.0, limits='burger', **SLOW)
    near, far = (max(best_shift(run, one).rms.values()) for one in (nearer, before))
    assert near < 0.2 * far


def test_a_run_without_motion_gives_no_model(folder, record, capsys):
    record(simulate(lambda *_: (0, 0), 1, 10.0), folder / 'still')

    assert main(['identify', 'still']) == 1

    assert 'tb3_1: its commands change too little to identify' in capsys.readouterr().err
    assert not (folder / 'model.yaml').exists()


@pytest.mark.parametrize(('quality', 'is_poor'), [(44.0, True), (75.0, False)])
def test_a_poor_fit_is_reported_though_its_standard_errors_are_small(quality, is_poor):
    response, errors = Response(0.92, 0.1, 0.2), Response(0.01, 0.01, 0.01)
    fits = {FORWARD: Fit(response, errors, quality), TURN: Fit(response, errors, 95.0)}
    found = Identified(fits, {FORWARD: response, TURN: response})

    notes = [*identified_notes({1: found})]
    assert bool(notes) == is_poor
    poor = 'tb3_1: the model explains less than 70 % of its forward speed;'
    assert all(note.startswith(poor) for note in notes)


CMD_VEL, GUARDED = '/tb3_1/cmd_vel', '/tb3_1/cmd_vel_guarded'


@pytest.fixture
def driven(tmp_path, make, write_bag):
    """A function that writes the bag of a robot whose base was sent speeds on some topics."""

    def driven(speeds):
        messages = []
        for i in range(20):
            messages.append(('/tb3_1/odom', i / 10, make('nav_msgs/msg/Odometry')))
            for topic, V in speeds.items():
                messages.append((topic, i / 10, make(TWIST, {'twist.linear.x': V * (i > 3)})))
        return write_bag(tmp_path / 'bag', messages)

    return driven


@pytest.mark.parametrize(
    ('guarded', 'V'),
    [(0.0, 0.2), (0.1, 0.1)],
    ids=['base hears cmd_vel itself', 'base hears its guard alone'],
)
def test_commands_are_those_that_moved_the_robot(driven, guarded, V):
    run = Run.load(driven({CMD_VEL: 0.2, GUARDED: guarded}))

    assert recorded_commands(run, pytest.fail)[1][1].max() == V


@pytest.mark.parametrize(
    ('options', 'limits'),
    [({'limits': 'waffle'}, 'waffle'), ({'model': 'waffle'}, 'waffle'), ({}, 'ideal')],
)
def test_the_limits_are_those_of_the_run(options, limits):
    assert limits_of(simulate('consensus', 2, 1.0, **options)) == limits
