import pytest

from setcmas_tools.player.commands import is_command

STAMPED = 'geometry_msgs/msg/TwistStamped'


@pytest.mark.parametrize(
    ('name', 'msgtype'),
    [
        ('/tb3_1/cmd_vel', STAMPED),
        ('/tb3_1/cmd_vel_wanted', STAMPED),
        ('/husky/velocity_controller/reference', 'geometry_msgs/msg/Twist'),
        ('/cmd_vel_nav', 'custom_msgs/msg/Velocity'),
        ('/pause', 'std_msgs/msg/Bool'),
        ('/tb3_1/pause', 'std_msgs/msg/Bool'),
        ('/paused', 'std_msgs/msg/Bool'),
        ('/emergency_stopped', 'std_msgs/msg/Bool'),
        ('/tb3_1/cmd_vel_guarded', 'custom_msgs/msg/Velocity'),
        ('/tb3_1/guard_state', 'diagnostic_msgs/msg/DiagnosticStatus'),
        ('/tb3_2/reset', 'std_msgs/msg/Empty'),
        ('/emulated_lab/fault', 'std_msgs/msg/String'),
        ('/bridge_state', 'diagnostic_msgs/msg/DiagnosticArray'),
        ('/fleet_time', 'sensor_msgs/msg/TimeReference'),
        ('/joy', 'sensor_msgs/msg/Joy'),
    ],
)
def test_what_robots_act_on_is_never_played(name, msgtype):
    assert is_command(name, msgtype)


@pytest.mark.parametrize(
    ('name', 'msgtype'),
    [
        ('/tb3_1/odom', 'nav_msgs/msg/Odometry'),
        ('/tb3_1/cmd_cart_vel', 'geometry_msgs/msg/Point32'),
        ('/fleet', 'std_msgs/msg/String'),
        ('/scan', 'sensor_msgs/msg/LaserScan'),
    ],
)
def test_what_was_measured_or_told_is_played(name, msgtype):
    assert not is_command(name, msgtype)
