import pytest
from identified_robots import TRUTH

from launch_scripts.cli import main
from setcmas_simu.robots.identified_robot import Response
from setcmas_tools import simulate
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
