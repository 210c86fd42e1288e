import math

import numpy as np
import pytest
from metrics_runs import compute

from setcmas_ctrl.laws.drawing import Sphere
from setcmas_tools.run.bag_conversion import convert
from setcmas_tools.run.run_records import (
    TRAIL,
    Counts,
    Drawing,
    DrawnOverTime,
    record_of,
    with_allowed,
)
from setcmas_tools.run.run_tables import read_communication, read_tables

CHANGES = [(2.0, 1, 2, 0.0), (0.0, 1, 2, 0.5), (0.0, 2, 1, 1.0)]


def test_the_graph_of_a_time():
    record = record_of({}, [], CHANGES, {})

    assert record.adjacency(1.0, 2).tolist() == [[0, 0.5], [1, 0]]
    assert record.adjacency(2.0, 3).tolist() == [[0, 0, 0], [1, 0, 0], [0, 0, 0]]


def test_a_trail_has_no_drawings_of_later_times():
    sphere = Sphere(0, 0, 0, 0.1, (1, 0, 0), 1)
    drawn = DrawnOverTime([Drawing(t, 1, 'traj_ref', TRAIL, sphere) for t in (0.0, 1.0, 2.0)])

    assert [one.t for one in drawn.trails(1.0)] == [0.0, 1.0]


@pytest.fixture
def bag(tmp_path, make, write_bag):
    """A bag of two robots, the first command after 1 s; robot 1 sent its state before."""

    def table(counts):
        return make('std_msgs/msg/Float64MultiArray', {'data': np.array(counts, dtype=float)})

    def bag(graphs=((0.9, [0, 1, 0, 0]), (2.0, [0, 1, 0.5, 0]))):
        messages = []
        for k in range(30):
            for robot in (1, 2):
                event = make('std_msgs/msg/UInt16', {'data': int(robot == 2 and k % 10 == 0)})
                messages.append((f'/tb3_{robot}/odom', 0.1 * k, make('nav_msgs/msg/Odometry')))
                messages.append((f'/tb3_{robot}/trig_event', 0.1 * k, event))
        messages.append(('/tb3_1/cmd_vel', 1.0, make('geometry_msgs/msg/TwistStamped')))
        messages.append(('/tb3_1/links', 1.5, table([0, 0, 0, np.nan, 1, 1, 0, np.nan])))
        messages.append(('/tb3_1/links', 2.5, table([0, 0, 0, np.nan, 2, 1, 1, 0.7])))
        messages.append(('/tb3_2/links', 2.5, table([0, 0, 0, np.nan, 0, 0, 0, np.nan])))
        for t, weights in graphs:
            graph = make('std_msgs/msg/Float32MultiArray', {'data': np.array(weights, np.float32)})
            messages.append(('/communication_graph', t, graph))
        messages.sort(key=lambda message: message[1])
        return write_bag(tmp_path / 'bag', messages)

    return bag


def test_a_record_from_a_bag(bag):
    folder = convert(bag()).folder
    record = read_communication(folder)

    assert record.links == {
        (1, 2): Counts(2, 1, 1, 0.7),
        (2, 1): Counts(0, 0, 0, pytest.approx(math.nan, nan_ok=True)),
    }
    # The first state of robot 1 was sent before the recorder listened.
    assert {robot: counts.sent for robot, counts in record.robots.items()} == {1: 1, 2: 3}
    assert record.robots[2].mean_interval == pytest.approx(1.0)
    assert record.triggers[:3].tolist() == [[-1, 1, 1], [-1, 2, 1], [-0.9, 1, 0]]
    assert record.changes.tolist() == [[0, 1, 2, 1], [1, 2, 1, 0.5]]


def test_a_bag_of_the_ros_1_stack_has_only_sent_messages(tmp_path, make, write_bag):
    messages = []
    for k in range(20):
        event = make('std_msgs/msg/UInt16', {'data': int(k % 5 == 0)})
        messages += [('/tb3_1/odom', 0.1 * k, make('nav_msgs/msg/Odometry'))]
        messages += [('/tb3_1/trig_event', 0.1 * k, event)]
    folder = convert(write_bag(tmp_path / 'bag', messages)).folder
    lines = str(compute(folder)).splitlines()

    assert read_communication(folder).robots[1].sent == 4
    assert lines[-1] == (
        'communication: 4 states sent (20.0 % of 20 evaluations triggered), those of a robot at '
        'least 0.50 s apart'
    )


def test_a_bag_of_periodic_communication_has_no_record(tmp_path, make, write_bag):
    bag = write_bag(tmp_path / 'bag', [('/tb3_1/odom', 0.0, make('nav_msgs/msg/Odometry'))])

    assert read_communication(convert(bag).folder) is None


@pytest.mark.parametrize(
    ('graphs', 'changes'),
    [
        (
            ((0.9, [0, 1, np.nan, np.nan]), (2.0, [np.nan, np.nan, 0.5, 0])),
            [[0, 1, 2, 1], [1, 2, 1, 0.5]],
        ),
        ((), [[0, 1, 2, 1], [0, 2, 1, 1]]),
    ],
    ids=['of two controller processes', 'none: a complete one'],
)
def test_graphs_of_a_bag(bag, graphs, changes):
    assert read_communication(convert(bag(graphs)).folder).changes.tolist() == changes


@pytest.mark.parametrize('rate', [10, 60, 200, 1000])
@pytest.mark.parametrize('delay', [-0.1, 0.0, 0.1, 0.7])
def test_allowed_velocities_belong_to_the_command_of_their_step(rate, delay):
    steps = np.arange(50.0)
    wanted = np.column_stack([steps / rate, np.ones(50), steps, steps])
    t = np.maximum((steps + max(delay, -0.0005 * rate)) / rate, 0.0)
    allowed = np.delete(np.column_stack([t, np.ones(50), -steps, steps, steps]), 20, axis=0)

    rows = with_allowed(wanted, allowed)

    assert rows[20, 4:].tolist() == [20, 20, 0]
    others = np.delete(rows, 20, axis=0)
    assert others[:, 4:].tolist() == np.column_stack([-others[:, 2], *others.T[[2, 2]]]).tolist()


def test_diagnostics_become_a_table_from_the_start_on(tmp_path, make, write_bag):
    statuses = [
        make(
            'diagnostic_msgs/msg/DiagnosticStatus',
            {'name': name, 'message': reason, 'level': 0, 'values': values},
        )
        for name, reason, values in (
            ('tb3_2', 'outside the arena', [state(make, 'stopped')]),
            ('tb3_1', '', [state(make, 'moving')]),
            ('camera', '', []),  # of another program
        )
    ]
    diagnostics = make('diagnostic_msgs/msg/DiagnosticArray', {'status': statuses})
    start = make('std_msgs/msg/Bool', {'data': False})
    odometry = make('nav_msgs/msg/Odometry', {'pose.pose.orientation.w': 1.0})
    messages = [
        ('/tb3_1/odom', 0.0, odometry),
        ('/paused', 0.5, start),
        ('/diagnostics', 0.75, diagnostics),
    ]
    bag = write_bag(tmp_path / 'bag', messages)

    record = read_tables(convert(bag).fleet).safety

    np.testing.assert_allclose(record.t, [0.25, 0.25])
    assert record.robot.tolist() == [1, 2]
    assert record.state.tolist() == ['moving', 'stopped']
    assert record.overruled.tolist() == [False, True]


def state(make, value):
    return make('diagnostic_msgs/msg/KeyValue', {'key': 'state', 'value': value})
