from dataclasses import replace

import numpy as np
import pytest
from identified_robots import TRUTH

from launch_scripts.cli import main
from setcmas_simu.robots.identified_robot import Response
from setcmas_tools import simulate
from setcmas_tools.measures.identification import (
    FORWARD,
    TURN,
    Fit,
    Identified,
    MeasuredSpeeds,
    fitted,
    identified_notes,
    limits_of,
    recorded_commands,
)
from setcmas_tools.run.run import Run


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
        odometry = make('nav_msgs/msg/Odometry', {'pose.pose.orientation.w': 1.0})
        messages = []
        for i in range(100):
            messages.append(('/tb3_1/odom', i / 10, odometry))
            for topic, V in speeds.items():
                twist = {'twist.linear.x': V * (i > 3)}
                message = make('geometry_msgs/msg/TwistStamped', twist)
                messages.append((topic, i / 10, message))
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


def test_the_limits_of_a_run_with_a_model_file_are_those_of_the_file(tmp_path):
    (tmp_path / 'truth.yaml').write_text(TRUTH)
    run = simulate('consensus', 2, 1.0, model=tmp_path / 'truth.yaml')
    assert limits_of(run) == 'burger'


def test_a_run_without_motion_gives_no_model(driven, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    assert main(['identify', str(driven({CMD_VEL: 0.0}))]) == 1

    assert 'tb3_1: its commands change too little to identify' in capsys.readouterr().err
    assert not (tmp_path / 'model.yaml').exists()


def test_of_a_recording_without_limits_the_user_is_told_which_the_model_gets(driven, capsys):
    bag = driven({CMD_VEL: 0.2})
    line = 'the recording has no velocity limits; using those of burger (see --limits)'

    main(['identify', str(bag), '-o', str(bag.with_suffix('.yaml'))])
    assert line in capsys.readouterr().err
    main(['identify', str(bag), '-o', str(bag.with_suffix('.yaml')), '--limits', 'waffle'])
    assert line not in capsys.readouterr().err


RATE_HZ = 50.0


def measured(response, changes, noise=0.0, seconds=40.0):
    """Return windows of 0.2 s of a speed that answers random steps, from its own integration."""
    rng = np.random.default_rng(1)
    t = np.arange(0.0, seconds, seconds / changes) + 0.1
    u = rng.uniform(-0.2, 0.2, len(t)) if changes > 1 else np.array([0.2])
    fine = np.arange(0.0, seconds, 1e-3)
    sent = np.where(
        fine - response.delay < t[0],
        0.0,
        u[np.searchsorted(t, fine - response.delay, side='right') - 1],
    )
    w = np.zeros(len(fine))
    for k in range(1, len(fine)):
        w[k] = w[k - 1] + 1e-3 / response.lag * (response.gain * sent[k - 1] - w[k - 1])
    way = np.concatenate([[0.0], np.cumsum(w[:-1]) * 1e-3])
    begin = np.arange(0.0, seconds - 0.3, 1.0 / RATE_HZ)
    end = begin + 0.2
    moved = np.interp(end, fine, way) - np.interp(begin, fine, way)
    y = moved / 0.2 + rng.normal(0.0, noise, len(begin))
    return MeasuredSpeeds(t, u, begin, end, y, 10.0)


@pytest.mark.parametrize(
    'response', [Response(0.9, 0.15, 0.2), Response(1.1, 0.4, 0.05), Response(0.8, 0.05, 0.6)]
)
@pytest.mark.parametrize('noise', [0.0, 0.01])
def test_gain_lag_and_delay_are_found(response, noise):
    found = fitted(measured(response, changes=40, noise=noise))

    assert found.times_known
    assert found.response.gain == pytest.approx(response.gain, rel=0.02)
    assert found.response.lag == pytest.approx(response.lag, rel=0.05, abs=0.005)
    assert found.response.delay == pytest.approx(response.delay, rel=0.05, abs=0.005)
    assert found.quality > 85.0
    assert abs(found.response.lag - response.lag) < 4 * found.errors.lag + 2e-3
    assert abs(found.response.delay - response.delay) < 4 * found.errors.delay + 2e-3


def test_a_robot_that_stands_or_ignores_commands_gives_no_values():
    standing = measured(Response(0.9, 0.15, 0.2), 40)
    noise = np.random.default_rng(2).normal(0.0, 0.05, len(standing.y))
    ignoring = replace(standing, y=noise)
    unmoved = replace(ignoring, t=np.array([0.0, 1.0]), u=np.zeros(2))

    assert not fitted(ignoring).gain_known
    assert not fitted(unmoved).gain_known


def test_a_constant_command_gives_neither_lag_nor_delay():
    constant = measured(Response(0.9, 0.15, 0.2), changes=1, noise=0.05)
    late = constant.begin > 2.0
    alone = replace(
        constant, begin=constant.begin[late], end=constant.end[late], y=constant.y[late]
    )

    found = fitted(alone)

    assert not found.times_known


def test_a_robot_that_follows_at_once_has_no_lag():
    """Its lag and delay cannot be distinguished, but their sum is known."""
    found = fitted(measured(Response(1.0, 1e-3, 0.0), changes=40, noise=0.01))

    assert found.times_known
    assert found.response.lag + found.response.delay < 0.01
    assert found.errors.delay < 0.02


@pytest.mark.parametrize('early', [0.02, 0.05, 0.09])
def test_gain_of_a_simulation_that_holds_a_command_for_its_whole_step(early):
    t = np.arange(0.0, 20.0, 0.2)
    u = -3.5 * np.exp(-1.5 * t)
    steps = np.arange(-1.0, 20.0, 0.1) + 0.1 - early  # each with the command of its end
    held = np.searchsorted(t, steps + 1e-9, side='right') - 1
    way = np.cumsum(np.where(held < 0, 0.0, 0.1 * u[held]))
    begin, end = steps[:-2], steps[2:]
    y = (way[2:] - way[:-2]) / (end - begin)

    found = fitted(MeasuredSpeeds(t, u, begin, end, y, 2.0))

    assert found.response.gain == pytest.approx(1.0, abs=0.002)
    assert found.response.delay == 0.0
    assert found.errors.delay == pytest.approx(early, abs=0.03)
    assert found.times_known
