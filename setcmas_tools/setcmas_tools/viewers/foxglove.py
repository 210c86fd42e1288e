"""Layout for Foxglove and Lichtblick: the scene, curves over time, pauses and diagnostics.

It has the form that both read: panels by id, and a tree of splits. Foxglove's own newer form
(`foxglove.layouts`) is none that Lichtblick knows.
"""

from __future__ import annotations

from functools import reduce
from typing import Any

from setcmas_simu.fleet import topics
from setcmas_simu.fleet.fleet import plot_hex
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.viewers.recording import SERIES, RecordedTopics

_MARKERS = ('visualization_msgs/msg/Marker', 'visualization_msgs/msg/MarkerArray')
_STATES = (topics.FLEET_PAUSE, topics.PAUSED, topics.EMERGENCY_STOPPED)
_GRID = 'metres'
_RECEIVED = {'enabled': True, 'timestampMethod': 'receiveTime'}


def foxglove_layout(recording: RecordedTopics) -> dict[str, Any]:
    """Return the content of a layout file."""
    curves = {f'Plot!{i}': _plot(recording, title) for i, title in enumerate(SERIES)}
    below = _state_panels(recording)
    layout = _split('row', '3D!scene', _even('column', list(curves)), 60)
    if below:
        layout = _split('column', layout, _even('row', list(below)), 75)
    return {
        'configById': {'3D!scene': _scene(recording)} | curves | below,
        'globalVariables': {},
        'userNodes': {},
        'playbackConfig': {'speed': 1},
        'layout': layout,
    }


def _scene(recording: RecordedTopics) -> dict[str, Any]:
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
        'topics': {name: {'visible': True} for name in recording.of_type(*_MARKERS)},
        'transforms': {},
        'layers': {_GRID: grid},
    }


def _plot(recording: RecordedTopics, title: str) -> dict[str, Any]:
    field = '.'.join(SERIES[title])
    return {
        'foxglovePanelTitle': title,
        'paths': [
            {'value': f'{topic}.{field}', 'label': robot_name(robot), 'color': plot_hex(robot)}
            | _RECEIVED
            for robot, topic in recording.odometry.items()
        ],
        'showXAxisLabels': True,
        'showYAxisLabels': True,
        'showLegend': title == next(iter(SERIES)),
        'legendDisplay': 'floating',
        'showPlotValuesInLegend': False,
        'isSynced': True,
        'xAxisVal': 'timestamp',
    }


def _state_panels(recording: RecordedTopics) -> dict[str, dict[str, Any]]:
    """Return the panels of what goes on and off, and of diagnostics, as far as recorded."""
    states = [name for name in _STATES if name in recording.types]
    states += [
        name for name in recording.of_type('std_msgs/msg/UInt16')
        if name.endswith(f'/{topics.TRIG_EVENT}')
    ]  # fmt: skip
    panels: dict[str, dict[str, Any]] = {}
    if states:
        paths = [{'value': f'{name}.data', 'label': name} | _RECEIVED for name in states]
        title = {'foxglovePanelTitle': 'pauses and events'}
        panels['StateTransitions!states'] = title | {'paths': paths, 'isSynced': True}
    if topics.DIAGNOSTICS in recording.types:
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
    """Return a tree of splits that gives all panels the same part."""

    def before(tree: Any, i: int) -> Any:
        return _split(direction, panels[i], tree, 100 / (len(panels) - i))

    return reduce(before, reversed(range(len(panels) - 1)), panels[-1])
