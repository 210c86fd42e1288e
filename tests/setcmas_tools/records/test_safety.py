"""What the safety let robots do, from the diagnostics of a recording."""

import numpy as np

from setcmas_tools.records.safety import read_csv
from setcmas_tools.tables.convert import convert


def test_diagnostics_become_a_table_from_the_start_on(make, write_bag, bag):
    statuses = [
        make(
            'diagnostic_msgs/msg/DiagnosticStatus',
            {'name': name, 'message': reason, 'level': 0, 'values': values},
        )
        for name, reason, values in (
            ('tb3_2', 'outside the arena', [state(make, 'stopped')]),
            ('tb3_1', '', [state(make, 'moving')]),
            ('camera', '', []),  # somebody else's
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

    record = read_csv(convert(bag).folder / 'safety.csv')

    np.testing.assert_allclose(record.t, [0.25, 0.25])
    assert record.robot.tolist() == [1, 2]
    assert (record.state, record.overruled.tolist()) == (['moving', 'stopped'], [False, True])


def state(make, value):
    return make('diagnostic_msgs/msg/KeyValue', {'key': 'state', 'value': value})
