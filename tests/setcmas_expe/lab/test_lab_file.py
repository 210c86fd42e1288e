import argparse
import re

import pytest

from setcmas_expe.lab.lab import LabRobot
from setcmas_expe.lab.lab_file import DEFAULT_FILE, LabOptions, load_lab
from setcmas_simu.errors import SetcmasError
from setcmas_simu.option_groups import take_values
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import ROBOT_LIMITS, VelocityLimits


@pytest.fixture
def lab_file(tmp_path):
    def write(text):
        path = tmp_path / 'lab.yaml'
        path.write_text(text)
        return path

    return write


def test_the_default_lab_has_robots_that_are_called_the_same_everywhere():
    lab = load_lab(DEFAULT_FILE, 2)

    assert lab.robots == (LabRobot(1, 'tb3_1', 'tb3_1'), LabRobot(2, 'tb3_2', 'tb3_2'))
    assert lab.mocap.topic_of(lab.robots[1]) == '/qualisys/tb3_2/odom'
    assert lab.robots[1].topic('cmd_vel') == '/tb3_2/cmd_vel'
    assert lab.limits == ROBOT_LIMITS['burger']
    assert lab.timeouts.pose_s == lab.timeouts.command_s == lab.timeouts.pause_s == 0.5
    assert lab.joystick_button == 7


def test_every_line_of_the_default_file_that_is_commented_out_is_accepted(lab_file):
    text = re.sub(r'(?m)^( *)# (robots:|  - |    mocap_name|    namespace)', r'\1\2',
                  DEFAULT_FILE.read_text())  # fmt: skip
    text = re.sub(r'(?m)^  # (topic|type):', r'  \1:', text)
    text = re.sub(r'(?m)^# (limits: \{|accel:|obstacles:|  - disc:|  - polygon:)', r'\1', text)
    text = text.replace('\nlimits: burger', '').replace('\nobstacles: []', '')
    lab = load_lab(lab_file(text.replace('preset: qualisys', 'preset: custom')))

    assert lab.nb_robots == 2
    assert lab.mocap.source.topic == '/my_mocap/{name}/pose'
    assert lab.limits == VelocityLimits(0.15, 1.5, 0.2, 0.16)
    assert lab.accel == 0.5
    assert str(lab.obstacles) == 'disc 1 2 0.5; polygon 0 0 1 0 1 1'


def test_what_a_file_says_goes_before_the_defaults(lab_file):
    lab = load_lab(
        lab_file(
            'robots:\n  - {number: 2, namespace: lab/b}\n  - {number: 1, mocap_name: Red}\n'
            'mocap: {preset: vicon, y_up: true}\n'
            'arena: {x: [-1, 2.5]}\nmin_separation: 0.5\nlimits: waffle\n'
            'timeouts: {command: 0.3}\nsafety: {motion_check: false}\n'
            'joystick: {button: 9}\n'
            'network: {static_peers: [10.0.0.2, robot3]}\n'
        )
    )

    assert not lab.checks_motion
    assert [robot.number for robot in lab.robots] == [1, 2]
    assert lab.mocap.topic_of(lab.robots[0]) == '/vicon/Red/Red'
    assert lab.mocap.source.message_type == 'geometry_msgs/msg/PoseStamped'
    assert lab.mocap.y_up
    assert lab.robots[1].topic('odom') == '/lab/b/odom'
    assert (lab.arena.xmin, lab.arena.xmax, lab.arena.ymin) == (-1.0, 2.5, -3.0)
    assert lab.limits == ROBOT_LIMITS['waffle']
    assert (lab.timeouts.command_s, lab.timeouts.pose_s) == (0.3, 0.5)
    assert lab.static_peers == ('10.0.0.2', 'robot3')


def test_bodies_without_topics_of_their_own_may_have_any_name(lab_file):
    lab = load_lab(
        lab_file(
            'robots:\n  - {number: 1, mocap_name: "3"}\n  - {number: 2, mocap_name: Red.Red}\n'
            'mocap: {preset: mocap4r2, topic: /lab/rigid_bodies}\n'
        )
    )

    assert [lab.mocap.topic_of(robot) for robot in lab.robots] == 2 * ['/lab/rigid_bodies']


def test_fewer_robots_than_the_lab_has_may_take_part(lab_file):
    path = lab_file('robots: [{number: 1}, {number: 2}, {number: 3}]\n')

    assert load_lab(path, 2).nb_robots == 2
    assert load_lab(path).nb_robots == 3
    with pytest.raises(SetcmasError, match='the lab has 3 robots; --nb-robots 4'):
        load_lab(path, 4)


@pytest.mark.parametrize(
    ('text', 'line', 'message'),
    [
        ('arena:\n  x: [-1, 1]\n y: 3\n', 3, 'not YAML'),
        ('\nrobot: 1\n', 2, "there is no key 'robot'.*did you mean robots"),
        ('mocap:\n  presett: vicon\n', 2, "no key 'mocap.presett'.*did you mean preset"),
        ('mocap:\n  preset: vikon\n', 2, "mocap.preset is 'vikon'.*did you mean vicon"),
        ('mocap: {preset: custom}\n', 1, 'custom together with mocap.topic'),
        ('mocap: {topic: /a/pose}\n', 1, 'with {name}'),
        ('mocap: {preset: mocap4r2, topic: "/{name}/pose"}\n', 1, 'of all bodies'),
        ('mocap: {preset: mocap4r2, type: Odometry}\n', 1, 'left out: mocap4r2 has its own type'),
        ('mocap: {y_up: maybe}\n', 1, "y_up is 'maybe'; it must be true or false"),
        ('arena: {x: [1, -1]}\n', 1, r'arena.x is \[1.0, -1.0\].*smaller one first'),
        ('arena:\n  x:\n  - 0\n  - wide\n', 4, r"arena.x\[1\] is 'wide'; it must be a number"),
        ('arena: {x: [.nan, 1]}\n', 1, 'is nan; it must be a finite number'),
        ('min_separation: 0\n', 1, 'min_separation is 0; it must be above 0'),
        (
            'limits: {forward: 1.0e+9, turn: 1, wheel: 1, wheel_separation: 1}\n',
            1,
            'limits.forward is 1000000000.0; it must be above 0 and at most 3',
        ),
        ('min_separation: true\n', 1, 'is True; it must be a number'),
        ('min_separation:\n', 1, 'min_separation is empty'),
        (
            'limits: segway\n',
            1,
            "is 'segway'; it must be burger, waffle, or a mapping with forward",
        ),
        ('limits: {forward: 1}\n', 1, 'a mapping with forward, turn, wheel, wheel_separation'),
        ('timeouts: {pose: 60}\n', 1, 'timeouts.pose is 60; it must be from 0.3 to 2 s'),
        ('joystick: {button: 1.5}\n', 1, 'button is 1.5; it must be a whole number from 0'),
        ('joystick: {topic: joy}\n', 1, 'a topic, such as /joy'),
        ('network: {static_peers: 10.0.0.1}\n', 1, "static_peers is '10.0.0.1'.*a list"),
        ('network: {static_peers: [a;b]}\n', 1, 'an address'),
        ('min_separation: 0.05\n', 1, 'is 0.05 m; it must be at least the width of a robot'),
        ('min_separation: 1\nmin_separation: 2\n', 2, 'appears twice'),
        ('robots: [{number: 2}]\n', 1, 'without a gap'),
        ('robots:\n- {number: 1}\n- {number: 1}\n', 3, "two robots have the number '1'"),
        ('robots:\n- {number: 1}\n- {number: 2, mocap_name: tb3_1}\n', 3, 'mocap_name'),
        ('robots:\n- {number: 1, namespace: "a b"}\n', 2, 'letters, digits'),
        ('robots:\n- {mocap_name: Red}\n', 2, 'a robot with a number'),
        ('robots: [{number: 1, start: [0, 1]}]\n', 1, 'x, y in m and the heading in rad'),
        ('robots: [{number: 1, start: [0, 1, .inf]}]\n', 1, 'must be a finite number'),
    ],
)
def test_a_mistake_is_reported_with_its_line(lab_file, text, line, message):
    path = lab_file(text)

    with pytest.raises(SetcmasError, match=message) as caught:
        load_lab(path)
    assert str(caught.value).startswith(f'{path}, line {line}: ')
    assert '\n' not in str(caught.value)


def parsed(*arguments):
    parser = argparse.ArgumentParser()
    LabOptions.add_to(parser)
    take_values(parser)
    return LabOptions.of(parser.parse_args(arguments))


def test_what_options_say_goes_before_the_lab_file():
    lab = parsed(
        '--nb-robots=3',
        '--mocap=vicon',
        '--limits=waffle',
        '--arena=-2,2.5,-1,1',
        '--min-separation=0.4',
        '--accel=0.5',
    ).chosen()

    assert lab.nb_robots == 3
    assert lab.mocap.preset == 'vicon'
    assert lab.limits == ROBOT_LIMITS['waffle']
    assert lab.arena == Arena(-2, 2.5, -1, 1)
    assert (lab.min_separation, lab.accel) == (0.4, 0.5)


def test_a_process_gets_the_same_lab():
    options = parsed('--arena=-2.25,2,-0.1,1', '--nb-robots', '2')

    assert parsed(*options.arguments()) == options


@pytest.mark.parametrize(
    'arena', ['', '1,2,3', '0,1,0,x', '1,0,0,1', '0,1,0,0', '0,inf,0,1', '0,1,0,1,2']
)
def test_an_arena_without_a_size_is_a_mistake(arena, capsys):
    with pytest.raises(SystemExit):
        parsed(f'--arena={arena}')

    assert f"--arena is '{arena}'; it must be XMIN,XMAX,YMIN,YMAX" in capsys.readouterr().err


def test_a_lidar_stop_needs_the_guards(lab_file):
    lab = lab_file('safety: {lidar_stop: true}\n')

    assert LabOptions(lab=lab).chosen().lidar_stop
    with pytest.raises(SetcmasError, match='--without-guard: the lab file sets lidar_stop'):
        LabOptions(lab=lab, without_guard=True).chosen()
