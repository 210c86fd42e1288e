"""Drawing of the way of a pose: from the robot to the law and back as a command."""

from __future__ import annotations

import svg

WIDTH, HEIGHT = 1120, 640
BOX = (180.0, 74.0)
SIMULATED, CONTROL, REAL, CHECK = '#e3f2fd', '#e8f5e9', '#eceff1', '#ffebee'


def station(x: float, y: float, fill: str, title: str, does: str) -> list[str]:
    """Return a box around its middle: who it is, and what it does."""
    corner = (x - BOX[0] / 2, y - BOX[1] / 2)
    head = svg.words((x, y - 16), title, 14, 'middle', 'font-weight="bold"')
    return [svg.box(corner, BOX, fill), head, *svg.paragraph((x, y + 3), does, 27)]


def topic(x: float, y: float, name: str, anchor: str = 'middle') -> str:
    """Return the name of a topic beside its arrow."""
    style = 'style="font-family: Roboto Mono, monospace"'
    return svg.words((x, y), name, 12, anchor, style)


def simulation() -> list[str]:
    """Return the way in a simulation."""
    y = 120
    return [
        svg.words((20, 36), 'In simulation', 17, 'start', 'font-weight="bold"'),
        *station(130, y, SIMULATED, 'virtual robot', 'steps the unicycle 10 times a second'),
        svg.arrow([(220, y), (368, y)]),
        topic(294, y - 8, '/tb3_i/odom'),
        *station(460, y, CONTROL, 'controller', 'calls your control(), cuts the velocity to vnom'),
        svg.arrow([(550, y), (708, y)]),
        topic(629, y - 8, 'cmd_cart_vel'),
        topic(629, y + 18, 'vx, vy'),
        *station(800, y, CONTROL, 'si_to_uni', 'turns towards the velocity: V, omega'),
        svg.arrow([(800, y + 37), (800, y + 80), (130, y + 80), (130, y + 39)]),
        topic(460, y + 73, '/tb3_i/cmd_vel'),
    ]


def laboratory() -> list[str]:
    """Return the way in an experiment."""
    y, low = 320, 480
    return [
        svg.words((20, 250), 'In the lab', 17, 'start', 'font-weight="bold"'),
        *station(130, y, REAL, 'motion capture', 'sees every body, or says it does'),
        svg.arrow([(220, y), (268, y)]),
        *station(360, y, CHECK, 'mocap bridge', 'believes a pose only if it can be true'),
        svg.arrow([(450, y), (618, y)]),
        topic(534, y - 8, '/mocap/tb3_i/odom'),
        *station(710, y, CONTROL, 'controller', 'the same law, the same function'),
        svg.arrow([(800, y), (898, y)]),
        topic(849, y - 8, 'cmd_cart_vel'),
        *station(990, y, CONTROL, 'si_to_uni', 'turns towards the velocity: V, omega'),
        svg.arrow([(990, y + 37), (990, low), (802, low)]),
        topic(982, y + 90, '/tb3_i/cmd_vel_wanted', 'end'),
        *station(710, low, CHECK, 'cmd_vel bridge', 'zero if anything is missing, old or odd'),
        svg.arrow([(620, low), (452, low)]),
        topic(536, low - 8, '/tb3_i/cmd_vel'),
        *station(360, low, REAL, 'TurtleBot3', 'a guard on it stops it when commands end'),
        svg.arrow([(270, low), (130, low), (130, y + 39)], dashed=True),
        svg.words((200, low - 8), 'moves', 12),
        svg.arrow([(360, y + 37), (360, 400), (660, 400), (660, low - 39)], dashed=True),
        svg.words((400, 394), 'how old, how sure', 12, 'start'),
        *station(710, low + 112, CHECK, 'pause node', 'space bar, joystick, /pause'),
        svg.arrow([(710, low + 75), (710, low + 39)]),
        topic(720, low + 61, '/paused', 'start'),
    ]


def picture() -> str:
    """Return the drawing."""
    title = "A pose's way from the robot, or from motion capture, to the law and back"
    return svg.drawing(WIDTH, HEIGHT, title, simulation() + laboratory())
