import pytest

from setcmas_tools.run.run import Run


def test_messages_have_the_time_at_which_they_were_sent(tmp_path, write_bag, make):
    def message(data):
        return make('std_msgs/msg/String', {'data': data})

    odometry = make('nav_msgs/msg/Odometry', {'pose.pose.orientation.w': 1.0})
    command = make('geometry_msgs/msg/TwistStamped', {})
    bag = write_bag(
        tmp_path / 'bag',
        [
            ('/tb3_1/odom', 0.9, odometry),
            ('/tb3_1/cmd_vel', 1.0, command),
            ('/tb3_1/message', 1.9, message('{"t": 0.0, "value": {"x": 5.0}}')),  # recorded late
            ('/tb3_1/message', 1.9, message('{"t": 0.8, "value": {"x": 7.0}}')),
            ('/tb3_1/message', 2.2, message('5.0')),  # of another program
            ('/tb3_1/message', 5.0, message('{"t": 0.2, "value": 6.0}')),  # t has started anew
            ('/tb3_1/odom', 5.1, odometry),
        ],
    )
    run = Run.load(bag)

    assert run.messages == [
        (0.0, 1, {'x': 5.0}),
        (0.8, 1, {'x': 7.0}),
        (pytest.approx(4.0), 1, 6.0),
    ]
    assert run.record is None
