"""How a fleet communicates: who hears whom, when robots send, what happens on the way."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from setcmas_ctrl.communication.channel import Channel
from setcmas_ctrl.communication.graph import (
    COMPLETE,
    PRESETS,
    CommunicationGraph,
    checked_adjacency,
)
from setcmas_ctrl.communication.graph_file import GraphDescription, load_graph
from setcmas_ctrl.communication.links import Links
from setcmas_ctrl.communication.triggering import CTC, Broadcast
from setcmas_ctrl.scripts.error_reports import ErrorReports
from setcmas_ctrl.scripts.loader import EXERCISES
from setcmas_simu.errors import SetcmasError

Graph = str | Path | ArrayLike
Condition = str | Path | Callable[..., Any] | None


@dataclass(frozen=True)
class Communication:
    """How a fleet communicates.

    Attributes:
        graph: Who hears whom.
        channel: What happens to messages on their way.
        event_triggered: Whether robots send their state only when a condition triggers.
        seed: Chooses the random numbers of the links.
    """

    graph: CommunicationGraph
    channel: Channel
    event_triggered: bool
    seed: int
    _condition: Condition = None

    @property
    def is_ideal(self) -> bool:
        """Whether all robots know the newest pose of each other, as in the ROS 1 stack."""
        return self.reaches_all and not self.event_triggered

    @property
    def reaches_all(self) -> bool:
        """Whether each message arrives at every robot, at once and as it was."""
        return self.graph.is_complete and self.channel.is_perfect

    @property
    def condition_script(self) -> Path | None:
        """The script of the triggering condition, if it is one.

        Raises:
            SetcmasError: There is no such script.
        """
        if self._condition is None or callable(self._condition):
            return None
        return find_condition(str(self._condition))

    def links(self, receivers: Sequence[int]) -> Links:
        """Return the links on which robots hear the fleet."""
        return Links(receivers, self.channel, self.seed)

    def broadcast(self, robot: int, reports: ErrorReports) -> Broadcast:
        """Return what decides when a robot sends its state.

        Raises:
            SetcmasError: The condition cannot be loaded.
        """
        condition = self._condition
        if callable(condition):
            code = getattr(condition, '__code__', None)
            return Broadcast(robot, condition, Path(code.co_filename if code else 'ctc'), reports)
        return Broadcast.of_script(robot, self.condition_script, reports)


def communication(
    nb_robots: int,
    *,
    graph: Graph = COMPLETE,
    range: float | None = None,  # noqa: A002 (the name of the option)
    event_triggered: bool = False,
    ctc: Condition = None,
    delay: float = 0.0,
    loss: float = 0.0,
    noise: float = 0.0,
    seed: int = 0,
) -> Communication:
    """Return how a fleet of nb_robots communicates.

    Args:
        nb_robots: Size of the fleet.
        graph: A preset, a graph file, or an adjacency matrix of shape (N, N).
        range: Distance in m beyond which robots do not hear each other; None is no limit.
        event_triggered: Whether robots send their state only when a condition triggers.
        ctc: The condition: a script as for `--ctc`, or a function; None is the default one.
        delay: In s.
        loss: Probability that a message is lost.
        noise: Standard deviation of received positions in m.
        seed: Chooses the random numbers of the links.

    Raises:
        SetcmasError: The graph does not suit the fleet, or a value makes no sense.
    """
    if ctc is not None and not event_triggered:
        raise SetcmasError('--ctc has an effect with --event-triggered only; add that')
    for name, value, most in (('delay', delay, 1e9), ('loss', loss, 1.0), ('noise', noise, 1e9)):
        if not 0 <= value <= most:
            raise SetcmasError(f'{name} is {value}; it must be a number from 0 to {most:g}')
    if range is not None and not range > 0:
        raise SetcmasError(f'range is {range}; it must be a number above 0')
    description = graph_description(graph)
    reach = math.inf if range is None else range
    return Communication(
        CommunicationGraph(description.segments(nb_robots), description.repeat, reach),
        Channel.of(nb_robots, delay, loss, noise, description.links),
        event_triggered,
        seed,
        ctc,
    )


def graph_description(graph: Graph) -> GraphDescription:
    """Return what a preset's name, a graph file or an adjacency matrix says.

    Raises:
        SetcmasError: There is no such preset or file, or the file is malformed.
    """
    if not isinstance(graph, (str, Path)):
        build = partial(checked_adjacency, graph)
        return GraphDescription(False, [], [('', math.inf, build)])
    path = graph_file(graph)
    if path is None:
        name = _preset(graph)
        return GraphDescription(False, [], [(name, math.inf, PRESETS[name])])
    if path.suffix not in ('.yaml', '.yml') and not path.is_file():
        raise SetcmasError(
            f"graph '{graph}' is unknown; it must be {', '.join(PRESETS)} or a YAML file"
        )
    return load_graph(path)


def graph_file(graph: str | Path) -> Path | None:
    """Return the file that `--graph` means, which may not exist; None if it is a preset."""
    return None if _preset(graph) in PRESETS else Path(graph)


def _preset(graph: str | Path) -> str:
    return str(graph).replace('-', '_')


def find_condition(name: str, exercise: bool = False) -> Path:
    """Return the script that `--ctc NAME` means.

    In this order: a path to a file; NAME.py in the current folder; if `exercise`, an exercise.

    Raises:
        SetcmasError: There is none.
    """
    for path in (Path(name), Path(f'{name}.py')):
        if path.is_file():
            return path.resolve()
    if exercise and name in EXERCISES:
        return EXERCISES.file(name)
    raise SetcmasError(
        f"script '{name}' of --ctc was not found; it must be a path, or the name of a script "
        f'in this folder with a function {CTC}'
    )
