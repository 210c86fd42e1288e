"""Names of robots, nodes and topics, all spelled here."""

from __future__ import annotations

import re
from collections.abc import Sequence

WORLD_FRAME = 'world'

# Relative to a robot's namespace.
ODOM = 'odom'
POSE = 'pose'
MARKER = 'marker'
CMD_CART_VEL = 'cmd_cart_vel'
CMD_CART_VEL_ALLOWED = 'cmd_cart_vel_allowed'
CMD_VEL = 'cmd_vel'
CMD_VEL_WANTED = 'cmd_vel_wanted'
CMD_VEL_GUARDED = 'cmd_vel_guarded'
MOTOR_POWER = 'motor_power'
BATTERY = 'battery_state'
SCAN = 'scan'
GUARD_STATE = 'guard_state'
BRIDGE_STATE = 'bridge_state'
POSE_STATE = 'pose_state'
TRIG_ODOM = 'trig_odom'
TRIG_EVENT = 'trig_event'
LINKS = 'links'
MESSAGE = 'message'
RESET = 'reset'
PAUSE = 'pause'
OF_ROBOT = (
    ODOM,
    POSE,
    CMD_CART_VEL,
    CMD_CART_VEL_ALLOWED,
    CMD_VEL,
    TRIG_ODOM,
    TRIG_EVENT,
    MESSAGE,
    RESET,
    PAUSE,
)
"""Topics of a robot that no drawing may use."""

# Of the whole fleet.
FLEET = '/fleet'
FLEET_RESET = '/reset'
FLEET_PAUSE = '/pause'
FLEET_TIME = '/fleet_time'
PAUSED = '/paused'
EMERGENCY_STOP = '/emergency_stop'
EMERGENCY_STOPPED = '/emergency_stopped'
DIAGNOSTICS = '/diagnostics'
ARENA = '/arena'
OBSTACLES = '/obstacles'
TASK = '/task'
COMMUNICATION_GRAPH = '/communication_graph'
EMULATED_FAULT = '/emulated_lab/fault'
CLOCK = '/clock'
TF = '/tf'
PARAMETER_EVENTS = '/parameter_events'
ROSOUT = '/rosout'
OF_ROS = (PARAMETER_EVENTS, ROSOUT)
"""Topics that are the same in every namespace."""

CMD_VEL_TYPES = ('twist_stamped', 'twist')
"""Message types of cmd_vel, the default first."""
AUTO = 'auto'
"""The type of cmd_vel that the robot listens to."""

VIRTUAL_ROBOTS = 'virtual_robots'
"""Node of a process of simulated robots."""
PLAYER_NODE = 'player'
RECORDER_NODE = 'recorder'
RECORDER_NODES = (RECORDER_NODE, 'rosbag2_recorder')
"""Nodes that listen to everything without being a robot."""
BRIDGES_NODE = 'bridges'
MOCAP_BRIDGE = 'mocap_bridge'
CMD_VEL_BRIDGE = 'cmd_vel_bridge'
CMD_VEL_GUARD_NODE = 'cmd_vel_guard'
PAUSE_NODE = 'pause'
ROBOT_PATTERN = re.compile(r'/tb3_([1-9][0-9]{0,3})/')
"""Finds the robot's number in a topic's full name."""
MAX_ROBOTS = 2000

CONTROLLERS = 'controllers'
"""Node with the parameters of a process of controllers."""


def robot_name(robot: int) -> str:
    """Return the name of a robot, which is also its namespace."""
    return f'tb3_{robot}'


def robot_frame(robot: int) -> str:
    """Return the frame of a robot on the ground between its wheels (REP-105), x forward."""
    return f'{robot_name(robot)}/base_footprint'


def robot_topic(robot: int, topic: str) -> str:
    """Return the full name of a robot's topic, such as `/tb3_2/odom`."""
    return f'/{robot_name(robot)}/{topic}'


def odometry_topic(robot: int) -> str:
    """Return the topic of a simulated robot's pose, such as `/tb3_2/odom`."""
    return robot_topic(robot, ODOM)


def mocap_topic(robot: int) -> str:
    """Return the topic of a real robot's verified pose, such as `/mocap/tb3_2/odom`."""
    return f'/mocap/{robot_name(robot)}/{ODOM}'


def pose_state_topic(robot: int) -> str:
    """Return the topic that says why poses of a robot are rejected."""
    return f'/mocap/{robot_name(robot)}/{POSE_STATE}'


def truth_topic(robot: int) -> str:
    """Return the topic of an emulated robot's true pose, such as `/emulated_lab/truth/tb3_2`.

    Its twist is that of the wheels. Real labs have no such topic.
    """
    return f'/emulated_lab/truth/{robot_name(robot)}'


def robot_of(topic: str) -> int | None:
    """Return the robot that a full topic name belongs to; None if it belongs to none."""
    found = ROBOT_PATTERN.search(topic)
    robot = int(found[1]) if found else 0
    return robot if 1 <= robot <= MAX_ROBOTS else None


def of_fleet(
    found: Sequence[tuple[str, list[str]]], namespace: str
) -> list[tuple[str, list[str]]]:
    """Return the topics of the fleet in a namespace ('' for the root), named as in the root.

    Args:
        found: Full names of the topics in the graph, and their types.
        namespace: Namespace of the fleet; fleets in namespaces within it are left out.
    """
    inside = [
        (name.removeprefix(namespace), types)
        for name, types in found
        if name.startswith(f'{namespace}/') or name in OF_ROS
    ]
    within = tuple(
        name.removesuffix(FLEET[1:])
        for name, types in inside
        if name.endswith(FLEET) and name != FLEET and 'std_msgs/msg/String' in types
    )
    return [(name, types) for name, types in inside if not name.startswith(within)]
