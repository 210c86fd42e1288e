"""Draws what the drawing functions of control scripts publish, for docs/control_scripts.md.

The script of that page is run by `setcmas run`; the messages are read from the bag.

python docs/generators/drawing_functions.py
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib as mpl

mpl.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle
from rosbags.highlevel import AnyReader

from setcmas_simu.fleet.palettes import plot_colour
from setcmas_simu.fleet.topics import ODOM, robot_topic
from setcmas_tools.plots.style import plot_style, save

DOCS = Path(__file__).parents[1]
ROBOTS = (1, 2, 3)
DURATION_S = 18


def example() -> str:
    """Return the script of the page that draws."""
    blocks = re.findall(r'```python\n(.*?)```', (DOCS / 'control_scripts.md').read_text(), re.S)
    return next(block for block in blocks if 'import rviz_marker' in block)


def record(folder: Path) -> Path:
    """Run the script and return the bag."""
    (folder / 'law.py').write_text(example())
    command = [str(Path(sys.executable).parent / 'setcmas'), 'run', '--algo', 'law', '-o', 'out']
    command += ['--nb-robots', str(len(ROBOTS)), '--duration', str(DURATION_S)]
    command += ['--pose', '1:-1,-3', '--pose', '2:3,1', '--pose', '3:-3,2']
    environment = {'ROS_DOMAIN_ID': '101', **os.environ}
    subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    return folder / 'out' / 'bag'


def draw_spheres(axes: plt.Axes, messages: list) -> int:
    """Draw what a display shows in the end: of each name and id the last sphere."""
    shown = {}
    for message in messages:
        for marker in getattr(message, 'markers', [message]):
            shown[marker.ns, marker.id] = marker
    for marker in shown.values():
        centre, colour = marker.pose.position, marker.color
        rgba = (colour.r, colour.g, colour.b, colour.a)
        circle = Circle((centre.x, centre.y), marker.scale.x / 2, color=rgba, lw=0, zorder=3)
        axes.add_patch(circle)
    return len(shown)


def draw_robot(axes: plt.Axes, odometry: list, robot: int, path_width: float) -> None:
    """Draw a robot's path, and the robot at its end."""
    x, y = np.array([(m.pose.pose.position.x, m.pose.pose.position.y) for m in odometry]).T
    q = odometry[-1].pose.pose.orientation
    theta = 2 * np.arctan2(q.z, q.w)
    outline = 0.28 * np.array([[1, -0.7, -0.7, 1], [0, 0.6, -0.6, 0]])
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    body = turn @ outline + [[x[-1]], [y[-1]]]
    axes.plot(x, y, color=plot_colour(robot), lw=path_width, alpha=0.5)
    axes.fill(*body, color=plot_colour(robot), zorder=4)
    inwards = 0.55 * np.array([x[-1], y[-1]])
    axes.annotate(f'tb3_{robot}', inwards, ha='center', va='center', zorder=5)


def picture(bag: Path, name: str, path_width: float, target: Path) -> None:
    """Draw what is on the topics /tb3_i/<name>, and the robots."""
    figure, axes = plt.subplots(figsize=(4.2, 4.2))
    with AnyReader([bag]) as reader:
        messages: dict[str, list] = {connection.topic: [] for connection in reader.connections}
        for connection, _, raw in reader.messages():
            messages[connection.topic].append(reader.deserialize(raw, connection.msgtype))
    spheres = 0
    for robot in ROBOTS:
        spheres += draw_spheres(axes, messages[robot_topic(robot, name)])
        draw_robot(axes, messages[robot_topic(robot, ODOM)], robot, path_width)
    axes.set(aspect='equal', xlim=(-3.6, 3.6), ylim=(-3.6, 3.6), xlabel='x (m)', ylabel='y (m)')
    axes.set_title(f'/tb3_i/{name} after {DURATION_S} s')
    save(figure, target)
    print(f'{target}: {spheres} spheres')


def main() -> None:
    """Make both pictures."""
    with tempfile.TemporaryDirectory() as folder:
        bag = record(Path(folder))
        pictures = DOCS / 'pictures'
        pictures.mkdir(exist_ok=True)
        with plot_style():
            picture(bag, 'goal', 0.8, pictures / 'rviz_marker.png')
            picture(bag, 'path', 0.0, pictures / 'rviz_marker_array.png')


if __name__ == '__main__':
    main()
