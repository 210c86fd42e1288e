"""Layout for PlotJuggler: the plane with all ways, and curves over time."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from setcmas_simu.fleet.fleet import plot_hex
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.viewers.recording import SERIES, RecordedTopics


def plotjuggler_layout(recording: RecordedTopics, file: str) -> str:
    """Return the text of a layout file.

    Args:
        recording: What was recorded.
        file: The mcap file as seen from the layout; PlotJuggler opens it with the layout.
    """
    root = Element('root', version='2.3.8')
    tabs = SubElement(root, 'tabbed_widget', {'parent': 'main_window', 'name': 'Main Window'})
    _fill(_area(tabs, 'over time', list(SERIES)), recording)
    plane = _area(tabs, 'plane', ['x (m), y (m)'])[0]
    plane.set('mode', 'XYPlot')
    for robot in recording.odometry:
        along_x, along_y = (_curve(recording, robot, title) for title in ('x (m)', 'y (m)'))
        name = robot_name(robot)
        look = {'name': name, 'color': plot_hex(robot)}
        SubElement(plane, 'curve', look, curve_x=along_x, curve_y=along_y)
    SubElement(tabs, 'currentTabIndex', index='0')
    SubElement(root, 'use_relative_time_offset', enabled='1')
    files = SubElement(root, 'previouslyLoaded_Datafiles')
    info = SubElement(files, 'fileInfo', filename=file, prefix='')
    loader = SubElement(info, 'plugin', ID='DataLoad MCAP')
    SubElement(
        loader,
        'parameters',
        use_timestamp='0',
        use_mcap_log_time='1',
        clamp_large_arrays='0',
        max_array_size='500',
        selected_topics=';'.join(sorted(recording.types)),
    )
    indent(root)
    return tostring(root, encoding='unicode')


def _area(tabs: Element, tab_name: str, titles: Sequence[str]) -> list[Element]:
    """Add a tab with plots below each other; returns these."""
    tab = SubElement(tabs, 'Tab', tab_name=tab_name, containers='1')
    sizes = ';'.join([f'{1 / len(titles):.6f}'] * len(titles))
    split = SubElement(
        SubElement(tab, 'Container'),
        'DockSplitter',
        orientation='-',
        count=str(len(titles)),
        sizes=sizes,
    )
    areas = [SubElement(split, 'DockArea', name=title) for title in titles]
    return [
        SubElement(area, 'plot', mode='TimeSeries', style='Lines', flip_x='false', flip_y='false')
        for area in areas
    ]


def _fill(plots: Sequence[Element], recording: RecordedTopics) -> None:
    for plot, title in zip(plots, SERIES, strict=True):
        for robot in recording.odometry:
            name = _curve(recording, robot, title)
            SubElement(plot, 'curve', name=name, color=plot_hex(robot))


def _curve(recording: RecordedTopics, robot: int, title: str) -> str:
    return '/'.join([recording.odometry[robot], *SERIES[title]])
