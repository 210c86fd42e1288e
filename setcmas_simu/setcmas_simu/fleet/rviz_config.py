"""Configuration of RViz 2 for a fleet: displays, topics, colours."""

from __future__ import annotations

from typing import Any

import yaml

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.palettes import colour

WP_REF = 'wp_ref'
TRAJ_REF = 'traj_ref'
"""Topics of the built-in control laws' drawings, in a robot's namespace."""

_TRAIL_LENGTH = 500
_TRAIL_STEP_M = 0.1


def rviz_config(robots: list[int], experiment: bool = False) -> str:
    """Return the text of a .rviz file for robots.

    In an experiment motion capture provides the poses, and the arena is shown.
    """
    displays = [
        _display('Grid', 'metres') | {'Cell Size': 1, 'Plane Cell Count': 20},
        _display('Axes', 'axes') | {'Length': 0.5, 'Radius': 0.02},
        _marker_array('obstacles', topics.OBSTACLES, depth=1),
    ]
    if experiment:
        displays.append(_marker_array('arena', topics.ARENA, depth=1))
    displays += [_robot(robot, experiment) for robot in robots]
    config = {
        'Panels': [{'Class': 'rviz_common/Displays', 'Name': 'Displays'}],
        'Visualization Manager': {
            'Class': '',
            'Displays': displays,
            'Enabled': True,
            'Global Options': {'Fixed Frame': topics.WORLD_FRAME, 'Frame Rate': 30},
            'Name': 'root',
        },
    }
    return yaml.safe_dump(config, sort_keys=False)


def _robot(robot: int, experiment: bool) -> dict[str, Any]:
    if experiment:
        odometry = topics.mocap_topic(robot)
        shown = [_odometry('pose', odometry, robot, keep=1)]
    else:
        odometry = topics.robot_topic(robot, topics.ODOM)
        pose = {'Shape': 'Arrow', 'Topic': _topic(topics.robot_topic(robot, topics.POSE))}
        shown = [
            _marker('robot', topics.robot_topic(robot, topics.MARKER)),
            _display('Pose', 'pose') | pose | _arrow(robot, 0.3),
        ]
    shown += [
        _odometry('trail', odometry, robot, keep=_TRAIL_LENGTH),
        _marker(WP_REF, topics.robot_topic(robot, WP_REF), latched=True),
        _marker_array(TRAJ_REF, topics.robot_topic(robot, TRAJ_REF), depth=_TRAIL_LENGTH),
    ]
    group = {'Class': 'rviz_common/Group', 'Displays': shown}
    return _display('Group', topics.robot_name(robot)) | group


def _odometry(name: str, topic: str, robot: int, keep: int) -> dict[str, Any]:
    tolerance = _TRAIL_STEP_M if keep > 1 else 0.001
    return _display('Odometry', name) | {
        'Angle Tolerance': tolerance,
        'Covariance': {'Value': False},
        'Keep': keep,
        'Position Tolerance': tolerance,
        'Shape': {'Value': 'Arrow'} | _arrow(robot, 0.3 if keep == 1 else 0.08),
        'Topic': _topic(topic),
    }


def _arrow(robot: int, length: float) -> dict[str, Any]:
    """Return the settings of an arrow of a length (m) in the robot's colour."""
    red, green, blue = (round(255 * channel) for channel in colour(robot))
    return {
        'Alpha': 1,
        'Color': f'{red}; {green}; {blue}',
        'Head Length': round(0.4 * length, 3),
        'Head Radius': round(0.2 * length, 3),
        'Shaft Length': round(0.6 * length, 3),
        'Shaft Radius': round(0.08 * length, 3),
    }


def _marker(name: str, topic: str, latched: bool = False) -> dict[str, Any]:
    return _display('Marker', name) | {'Namespaces': {}, 'Topic': _topic(topic, latched=latched)}


def _marker_array(name: str, topic: str, depth: int) -> dict[str, Any]:
    described = _topic(topic, depth, latched=True)
    del described['Filter size']  # not a property of MarkerArray
    return _display('MarkerArray', name) | {'Namespaces': {}, 'Topic': described}


def _topic(name: str, depth: int = 5, latched: bool = False) -> dict[str, Any]:
    return {
        'Depth': depth,
        'Durability Policy': 'Transient Local' if latched else 'Volatile',
        'Filter size': 10,
        'History Policy': 'Keep Last',
        'Reliability Policy': 'Reliable',
        'Value': name,
    }


def _display(kind: str, name: str) -> dict[str, Any]:
    return {'Class': f'rviz_default_plugins/{kind}', 'Enabled': True, 'Name': name, 'Value': True}
