"""Network as a control script may ask about it: `from setcmas_ctrl import network`.

    def control(robotNo, nbRobots, poses, t):
        for j in network.neighbours():            # robots that this robot hears
            weight = network.adjacency()[robotNo - 1, j - 1]

The answers are those for the robot whose `control` is being called, at this time.
"""

from __future__ import annotations

from setcmas_ctrl.communication import graph as communication_graph
from setcmas_simu.arrays import Floats

# Robots of a process share this module: each call of a control law sets the two anew.
_robot = 0
_adjacency: Floats | None = None


def neighbours() -> list[int]:
    """Return the numbers of the robots that this robot hears, sorted.

    Raises:
        RuntimeError: No `control` is being called.
    """
    return communication_graph.neighbours(adjacency(), _robot)


def adjacency() -> Floats:
    """Return the adjacency matrix: [i - 1, j - 1] is the weight with which i hears j, 0 if not.

    Returns:
        A read-only array of shape (nbRobots, nbRobots).

    Raises:
        RuntimeError: No `control` is being called.
    """
    if _adjacency is None:
        raise RuntimeError(
            'network answers only while setcmas calls control; '
            'to try a function by itself: from setcmas_tools import simulate'
        )
    return _adjacency


def laplacian() -> Floats:
    """Return the Laplacian of the graph, diag(sum_j a_ij) - A, shape (nbRobots, nbRobots).

    Raises:
        RuntimeError: No `control` is being called.
    """
    return communication_graph.laplacian(adjacency())


def begin_call(robot: int, matrix: Floats) -> None:
    """Answer for a robot from now on (for those who call control laws)."""
    global _robot, _adjacency
    _robot, _adjacency = robot, matrix


def end_call() -> None:
    """Answer no more."""
    global _adjacency
    _adjacency = None
