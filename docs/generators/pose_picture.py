"""Drawing of the way of a pose: from the robot to the law and back as a command."""

from __future__ import annotations

import svg

WIDTH, HEIGHT = 960, 590
BOX = (164.0, 74.0)
SIMULATED, CONTROL, REAL, CHECK = '#e3f2fd', '#e8f5e9', '#eceff1', '#ffebee'


def station(x: float, y: float, fill: str, title: str, does: str) -> list[str]:
    """Return a box around its middle: who it is, and what it does."""
    corner = (x - BOX[0] / 2, y - BOX[1] / 2)
    head = svg.words((x, y - 16), title, 14, 'middle', 'font-weight="bold"')
    return [svg.box(corner, BOX, fill), head, *svg.paragraph((x, y + 3), does, 25)]


def topic(x: float, y: float, name: str, anchor: str = 'middle') -> str:
    """Return the name of a topic beside its arrow."""
    style = 'style="font-family: Roboto Mono, monospace"'
    return svg.words((x, y), name, 12, anchor, style)


def simulation() -> list[str]:
    """Return the way in a simulation."""
    y = 95
    return [
        svg.words((13, 30), 'In simulation', 17, 'start', 'font-weight="bold"'),
        *station(95, y, SIMULATED, 'virtual robot', 'moves 10 times a second'),
        svg.arrow([(177, y), (311, y)]),
        topic(244, y - 8, '/tb3_i/odom'),
        *station(395, y, CONTROL, 'controller', 'calls your control(), cuts the velocity to vnom'),
        svg.arrow([(477, y), (611, y)]),
        topic(544, y - 8, 'cmd_cart_vel'),
        topic(544, y + 18, 'vx, vy'),
        *station(695, y, CONTROL, 'si_to_uni', 'turns towards the velocity'),
        svg.arrow([(695, y + 37), (695, y + 75), (95, y + 75), (95, y + 39)]),
        topic(395, y + 68, '/tb3_i/cmd_vel: V, omega'),
    ]


def laboratory() -> list[str]:
    """Return the way in an experiment."""
    y, low = 275, 430
    return [
        svg.words((13, 215), 'In the lab', 17, 'start', 'font-weight="bold"'),
        *station(95, y, REAL, 'motion capture', 'sees every body, or says it does'),
        svg.arrow([(177, y), (221, y)]),
        *station(305, y, CHECK, 'mocap bridge', 'believes a pose only if it can be true'),
        svg.arrow([(387, y), (521, y)]),
        topic(454, y - 8, '/mocap/tb3_i/odom'),
        *station(605, y, CONTROL, 'controller', 'the same law, the same function'),
        svg.arrow([(687, y), (781, y)]),
        topic(734, y - 8, 'cmd_cart_vel'),
        *station(865, y, CONTROL, 'si_to_uni', 'turns towards the velocity'),
        svg.arrow([(865, y + 37), (865, low), (689, low)]),
        topic(857, low - 60, '/tb3_i/cmd_vel_wanted', 'end'),
        *station(605, low, CHECK, 'cmd_vel bridge', 'zero if anything is missing, old or odd'),
        svg.arrow([(523, low), (389, low)]),
        topic(456, low - 8, '/tb3_i/cmd_vel'),
        *station(305, low, REAL, 'TurtleBot3', 'its guard lets commands through'),
        svg.arrow([(223, low), (95, low), (95, y + 39)], dashed=True),
        svg.words((160, low - 8), 'moves', 12),
        svg.arrow([(305, y + 37), (305, 352), (560, 352), (560, low - 39)], dashed=True),
        svg.words((400, 346), 'how old, how sure', 12),
        *station(605, low + 112, CHECK, 'pause node', 'keys, joystick, /pause'),
        svg.arrow([(605, low + 75), (605, low + 39)]),
        topic(615, low + 61, '/paused', 'start'),
    ]


def picture() -> str:
    """Return the drawing."""
    title = "A pose's way from the robot, or from motion capture, to the law and back"
    return svg.drawing(WIDTH, HEIGHT, title, simulation() + laboratory())
