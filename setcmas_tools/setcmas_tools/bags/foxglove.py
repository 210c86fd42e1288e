"""Layout for Foxglove and Lichtblick: the scene, curves over time, pauses and diagnostics.

It has the form that both programs read: panels by id, and a tree of splits. Lichtblick does not
read Foxglove's newer form (`foxglove.layouts`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import reduce
from pathlib import Path
from typing import Any

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.palettes import plot_hex
from setcmas_simu.fleet.topics import robot_name

_SERIES = {
    'x (m)': 'pose.pose.position.x',
    'y (m)': 'pose.pose.position.y',
    'speed (m/s)': 'twist.twist.linear.x',
}
"""Titles of the curves over time, and their fields in a robot's odometry."""
_MARKERS = ('visualization_msgs/msg/Marker', 'visualization_msgs/msg/MarkerArray')
_STATES = (topics.FLEET_PAUSE, topics.PAUSED, topics.EMERGENCY_STOPPED)
_GRID = 'metres'
_RECEIVED = {'enabled': True, 'timestampMethod': 'receiveTime'}


def odometry_topics(types: Mapping[str, str]) -> dict[int, str]:
    """Return the topic of each robot's poses: from motion capture if recorded, else its wheels."""
    found = {topics.robot_of(name) for name in types if topics.is_odometry(name)}
    return {
        robot: next(
            name
            for name in (topics.mocap_topic(robot), topics.odometry_topic(robot))
            if name in types
        )
        for robot in sorted(number for number in found if number)
    }


def _of_type(types: Mapping[str, str], *wanted: str) -> list[str]:
    """Return the topics of some message types, sorted by robot number."""
    names = [name for name, msgtype in types.items() if msgtype in wanted]
    return sorted(names, key=lambda name: (topics.robot_of(name) or 0, name))


def write_layout(bag: Path, types: Mapping[str, str]) -> Path | None:
    """Write layouts/foxglove.json next to a bag; BAG_layouts if the folder is not named bag.

    Args:
        bag: The folder of the bag.
        types: The message types of its topics by name.

    Returns:
        The file; None if no robot was recorded.

    Raises:
        OSError: The file cannot be written.
    """
    if not odometry_topics(types):
        return None
    bag = bag.resolve()
    folder = bag.parent / ('layouts' if bag.name == 'bag' else f'{bag.name}_layouts')
    folder.mkdir(exist_ok=True)
    file = folder / 'foxglove.json'
    file.write_text(f'{json.dumps(foxglove_layout(types), indent=1)}\n', encoding='utf-8')
    return file


def foxglove_layout(types: Mapping[str, str]) -> dict[str, Any]:
    """Return the content of a layout file for topics with these types, by name."""
    curves = {f'Plot!{i}': _plot(types, title) for i, title in enumerate(_SERIES)}
    below = _state_panels(types)
    layout = _split('row', '3D!scene', _even('column', list(curves)), 60)
    if below:
        layout = _split('column', layout, _even('row', list(below)), 75)
    return {
        'configById': {'3D!scene': _scene(types)} | curves | below,
        'globalVariables': {},
        'userNodes': {},
        'playbackConfig': {'speed': 1},
        'layout': layout,
    }


def _scene(types: Mapping[str, str]) -> dict[str, Any]:
    grid = {
        'layerId': 'foxglove.Grid',
        'instanceId': _GRID,
        'label': 'metres',
        'visible': True,
        'size': 20,
        'divisions': 20,
        'lineWidth': 1,
        'color': '#8888884d',
        'position': [0, 0, 0],
        'rotation': [0, 0, 0],
    }
    return {
        'foxglovePanelTitle': 'fleet',
        'followTf': topics.WORLD_FRAME,
        'followMode': 'follow-none',
        'cameraState': {
            'perspective': True,
            'distance': 20,
            'phi': 30,
            'thetaOffset': 0,
            'target': [0, 0, 0],
            'targetOffset': [0, 0, 0],
            'targetOrientation': [0, 0, 0, 1],
            'fovy': 45,
            'near': 0.1,
            'far': 1000,
        },
        'scene': {'transforms': {'lineWidth': 0, 'labelSize': 0.15}},
        'topics': {name: {'visible': True} for name in _of_type(types, *_MARKERS)},
        'transforms': {},
        'layers': {_GRID: grid},
    }


def _plot(types: Mapping[str, str], title: str) -> dict[str, Any]:
    return {
        'foxglovePanelTitle': title,
        'paths': [
            {
                'value': f'{topic}.{_SERIES[title]}',
                'label': robot_name(robot),
                'color': plot_hex(robot),
            }
            | _RECEIVED
            for robot, topic in odometry_topics(types).items()
        ],
        'showXAxisLabels': True,
        'showYAxisLabels': True,
        'showLegend': title == next(iter(_SERIES)),
        'legendDisplay': 'floating',
        'showPlotValuesInLegend': False,
        'isSynced': True,
        'xAxisVal': 'timestamp',
    }


def _state_panels(types: Mapping[str, str]) -> dict[str, dict[str, Any]]:
    """Return the panels of pauses, stops, broadcasts and diagnostics, if recorded."""
    states = [name for name in _STATES if name in types]
    states += [
        name for name in _of_type(types, 'std_msgs/msg/UInt16')
        if name.endswith(f'/{topics.TRIG_EVENT}')
    ]  # fmt: skip
    panels: dict[str, dict[str, Any]] = {}
    if states:
        paths = [{'value': f'{name}.data', 'label': name} | _RECEIVED for name in states]
        title = {'foxglovePanelTitle': 'pauses and events'}
        panels['StateTransitions!states'] = title | {'paths': paths, 'isSynced': True}
    if topics.DIAGNOSTICS in types:
        panels['DiagnosticSummary!diagnostics'] = {
            'topicToRender': topics.DIAGNOSTICS,
            'minLevel': 0,
            'pinnedIds': [],
            'hardwareIdFilter': '',
            'sortByLevel': True,
        }
    return panels


def _split(direction: str, first: Any, second: Any, percentage: float) -> dict[str, Any]:
    return {
        'direction': direction,
        'first': first,
        'second': second,
        'splitPercentage': percentage,
    }


def _even(direction: str, panels: list[str]) -> Any:
    """Return a tree of splits in which all panels have the same size."""

    def before(tree: Any, i: int) -> Any:
        return _split(direction, panels[i], tree, 100 / (len(panels) - i))

    return reduce(before, reversed(range(len(panels) - 1)), panels[-1])
