"""Communication network, for control scripts: `from setcmas_ctrl import network`.

    def control(robotNo, nbRobots, poses, t):
        for j in network.neighbours():            # robots whose states this robot receives
            weight = network.adjacency()[robotNo - 1, j - 1]

The answers are for the robot whose `control` is running, at the current time.
"""

from __future__ import annotations

from setcmas_ctrl.communication import graph as communication_graph
from setcmas_simu.arrays import Floats

# All robots of a process share this module: each call of a control law sets both anew.
_robot = 0
_adjacency: Floats | None = None


def neighbours() -> list[int]:
    """Return the numbers of the robots whose states this robot receives, sorted.

    Raises:
        RuntimeError: Called outside `control`.
    """
    return communication_graph.neighbours(adjacency(), _robot)


def adjacency() -> Floats:
    """Return the adjacency matrix: [i - 1, j - 1] is the weight that i gives j, 0 without a link.

    Returns:
        A read-only array of shape (nbRobots, nbRobots).

    Raises:
        RuntimeError: Called outside `control`.
    """
    if _adjacency is None:
        raise RuntimeError(
            'network works only while setcmas calls control; '
            'to try a function alone: from setcmas_tools import simulate'
        )
    return _adjacency


def laplacian() -> Floats:
    """Return the Laplacian of the graph, diag(sum_j a_ij) - A, shape (nbRobots, nbRobots).

    Raises:
        RuntimeError: Called outside `control`.
    """
    return communication_graph.laplacian(adjacency())


def begin_call(robot: int, nb_robots: int, matrix: Floats | None = None) -> None:
    """Answer for a robot from now on (for callers of control laws); no matrix is complete."""
    global _robot, _adjacency
    _robot = robot
    _adjacency = communication_graph.complete(nb_robots) if matrix is None else matrix


def end_call() -> None:
    """Stop answering."""
    global _adjacency
    _adjacency = None
