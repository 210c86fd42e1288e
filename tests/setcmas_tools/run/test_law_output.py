"""What the safety let robots do, from the diagnostics of a recording."""

import numpy as np
import pytest

from setcmas_tools.run.bag_conversion import convert
from setcmas_tools.run.law_output import with_allowed
from setcmas_tools.run.run_tables import read_tables


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


def test_diagnostics_become_a_table_from_the_start_on(make, write_bag, bag):
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
    write_bag(bag, messages)

    record = read_tables(convert(bag).fleet).safety

    np.testing.assert_allclose(record.t, [0.25, 0.25])
    assert record.robot.tolist() == [1, 2]
    assert (record.state, record.overruled.tolist()) == (['moving', 'stopped'], [False, True])


def state(make, value):
    return make('diagnostic_msgs/msg/KeyValue', {'key': 'state', 'value': value})
