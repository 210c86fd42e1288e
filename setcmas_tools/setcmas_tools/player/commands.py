"""Topics never played, because something acts on them."""

from __future__ import annotations

from setcmas_simu.fleet import topics

_NAMES = (topics.PAUSE, topics.RESET, topics.PAUSED.strip('/'), topics.GUARD_STATE)
_OF_FLEETS = (
    topics.BRIDGE_STATE,
    topics.EMERGENCY_STOP,
    topics.EMERGENCY_STOPPED,
    topics.EMULATED_FAULT,
    topics.FLEET_TIME,
    topics.LOCKSTEP,
)
_BEGIN = 'cmd_'  # of any stack: cmd_vel, cmd_vel_wanted, cmd_vel_nav
_TYPES = (
    'ackermann_msgs/msg/AckermannDrive',
    'ackermann_msgs/msg/AckermannDriveStamped',
    'geometry_msgs/msg/Twist',
    'geometry_msgs/msg/TwistStamped',
    'sensor_msgs/msg/Joy',  # its button starts experiments
    'trajectory_msgs/msg/JointTrajectory',
)


def is_command(name: str, msgtype: str) -> bool:
    """Return whether robots, or what drives them, may act on a topic.

    A robot must never move because somebody looks at a recording, not even one that is switched on
    later: so these topics are left out whoever listens. No program acts on cmd_cart_vel, which
    tells what a law has returned.
    """
    last = name.rpartition('/')[2]
    if msgtype in _TYPES or name in _OF_FLEETS or last in _NAMES:
        return True
    return last.startswith(_BEGIN) and last != topics.CMD_CART_VEL
