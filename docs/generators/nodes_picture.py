"""Drawing of the nodes and topics of a fleet, read from the ROS graph while it runs.

python docs/generators/nodes_picture.py     starts two robots and their controllers
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import svg

if TYPE_CHECKING:
    from rclpy.node import Node

PICTURE = Path(__file__).parents[1] / 'pictures' / 'nodes.svg'
COMMANDS = ('setcmas simu --nb-robots 2', 'setcmas ctrl --algo consensus')
"""The processes, from left to right."""

NODES = {
    'virtual_robot': (138.0, 'moves the robot at 10 Hz'),
    'virtual_robots': (138.0, 'announces the fleet'),
    'controller': (500.0, 'calls your control() at 5 Hz'),
    'controllers': (500.0, 'what all controllers share'),
    'si_to_uni': (872.0, 'turns vx, vy into V, omega'),
}
"""By the name of a node: its place from left to right, and what it does."""
ROWS = {'/tb3_1': 102.0, '/tb3_2': 262.0, '': 416.0}
FRAMES = ((14.0, 248.0, '#e3f2fd'), (376.0, 622.0, '#e8f5e9'))  # left, width, colour
BOX, WIDTH, HEIGHT = (216.0, 88.0), 1012, 486
BELOW = 26.0  # of an arrow that runs back, under the nodes
MONO = 'style="font-family: Roboto Mono, monospace"'
NOT_DRAWN = ('/rosout', '/parameter_events', '/_', '/tf')  # of ROS, hidden, or not everywhere


class Ends(NamedTuple):
    """The topics of a node, and an identifier of its process."""

    published: frozenset[str]
    subscribed: frozenset[str]
    process: bytes


Graph = dict[str, Ends]
"""The nodes of a fleet by their full names."""


def graph_seen_by(node: Node) -> Graph:
    """Return the nodes of the fleet with their topics."""
    graph = {}
    for name, namespace in sorted(node.get_node_names_and_namespaces()):
        if name in NODES:
            sent = drawn(node.get_publisher_names_and_types_by_node(name, namespace))
            heard = drawn(node.get_subscriber_names_and_types_by_node(name, namespace))
            processes = {
                bytes(one.endpoint_gid)[:12]  # of its DDS participant
                for topic in sent
                for one in node.get_publishers_info_by_topic(topic)
                if (one.node_name, one.node_namespace) == (name, namespace)
            }
            graph[f'{namespace.rstrip("/")}/{name}'] = Ends(
                sent, heard, min(processes, default=b'')
            )
    return graph


def drawn(found: list[tuple[str, list[str]]]) -> frozenset[str]:
    """Return the names of topics, without those that every node has."""
    return frozenset(topic for topic, _ in found if not topic.startswith(NOT_DRAWN))


def picture(graph: Graph) -> str:
    """Return the drawing of a graph.

    Raises:
        ValueError: A node is in another process than it is drawn in.
    """
    parts = []
    for (left, width, fill), command in zip(FRAMES, COMMANDS, strict=True):
        parts.append(svg.box((left, 10), (width, HEIGHT - 20), fill))
        parts.append(svg.words((left + 14, 34), command, 14, 'start', MONO))
    middles = {name: place(name) for name in graph}
    frames = {(x < FRAMES[1][0], graph[name].process) for name, (x, _) in middles.items()}
    if len(frames) != len(FRAMES):
        raise ValueError('nodes of one frame are in several processes')
    published = frozenset().union(*(ends.published for ends in graph.values()))
    subscribed = frozenset().union(*(ends.subscribed for ends in graph.values()))
    for name, ends in graph.items():
        parts += station(name, ends.published - subscribed, ends.subscribed - published)
    for sender, ends in graph.items():
        for topic in sorted(ends.published):
            for receiver, others in graph.items():
                if topic in others.subscribed:
                    parts += way(middles[sender], middles[receiver], topic)
    x, y = place('/si_to_uni')
    parts.append(svg.words((x, y - 6), 'Whoever publishes cmd_cart_vel', 14))
    parts.append(svg.words((x, y + 14), 'drives the robot.', 14))
    return svg.drawing(WIDTH, HEIGHT, 'The nodes and topics of two robots', parts)


def place(name: str) -> svg.Point:
    """Return the middle of a node."""
    namespace, _, base = name.rpartition('/')
    return NODES[base][0], ROWS[namespace]


def station(name: str, sent: frozenset[str], heard: frozenset[str]) -> list[str]:
    """Return a node: its name, and the topics whose other ends are outside the fleet."""
    x, y = place(name)
    namespace, _, base = name.rpartition('/')
    parts = [
        svg.box((x - BOX[0] / 2, y - BOX[1] / 2), BOX, 'white'),
        svg.words((x, y - 22), name, 14, 'middle', f'font-weight="bold" {MONO}'),
        svg.words((x, y - 3), NODES[base][1], 12),
    ]
    at = y + 17
    for way, topics in (('in', heard), ('out', sent)):
        if topics:
            names = ', '.join(sorted(one.removeprefix(f'{namespace or None}/') for one in topics))
            parts.append(label(x, at, f'{way}: {names}'))
            at += 18
    return parts


def way(sender: svg.Point, receiver: svg.Point, topic: str) -> list[str]:
    """Return the arrow of a topic: straight to the right, or back below the nodes."""
    (x, y), (to, low) = sender, receiver
    if x < to and y == low:
        begin, end = x + BOX[0] / 2, to - BOX[0] / 2
        return [svg.arrow([(begin, y), (end, y)]), label((begin + end) / 2, y - 8, topic)]
    edge = y + BOX[1] / 2
    points = [(x, edge), (x, edge + BELOW), (to, edge + BELOW), (to, low + BOX[1] / 2)]
    return [svg.arrow(points), label((x + to) / 2, edge + BELOW - 7, topic)]


def label(x: float, y: float, topic: str) -> str:
    """Return the name of a topic."""
    return svg.words((x, y), topic, 12, 'middle', MONO)


@contextlib.contextmanager
def fleet() -> Iterator[None]:
    """Run the processes until the end of the block."""
    with tempfile.TemporaryDirectory() as folder:
        processes = [
            subprocess.Popen(
                [Path(sys.executable).parent / 'setcmas', *command.split()[1:]],
                cwd=folder,
                stdout=subprocess.DEVNULL,
            )
            for command in COMMANDS
        ]
        try:
            yield
        finally:
            for process in reversed(processes):
                process.send_signal(signal.SIGINT)
                process.wait()


def settled_graph(node: Node) -> Graph:
    """Wait until the last node is there and the graph no longer changes; return it."""
    graph, before = graph_seen_by(node), None
    while '/tb3_2/si_to_uni' not in graph or graph != before:
        time.sleep(3.0)
        graph, before = graph_seen_by(node), graph
    return graph


def main() -> None:
    """Write the drawing of a fleet that runs."""
    import rclpy

    sys.path.insert(0, str(Path(__file__).parents[2] / 'tests'))
    from ros_domain import reserved_domain

    with reserved_domain() as domain:
        os.environ.update(ROS_DOMAIN_ID=str(domain), ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
        rclpy.init()
        node = rclpy.create_node('reader')
        with fleet():
            PICTURE.write_text(picture(settled_graph(node)))
    print(f'{PICTURE} written')


if __name__ == '__main__':
    main()
