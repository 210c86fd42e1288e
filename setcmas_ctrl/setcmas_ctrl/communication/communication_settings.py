"""Settings of communication: graph, event triggering, channels."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from setcmas_ctrl.communication.channel import Channel
from setcmas_ctrl.communication.communication_options import CommunicationOptions, Condition, Graph
from setcmas_ctrl.communication.graph import PRESETS, CommunicationGraph, checked_adjacency
from setcmas_ctrl.communication.graph_file import GraphDescription, load_graph
from setcmas_ctrl.communication.links import Links
from setcmas_ctrl.communication.triggering import CTC, THRESHOLD_M, Broadcast, further_than
from setcmas_ctrl.scripts.loader import compile_script
from setcmas_ctrl.scripts.script_errors import ErrorReports
from setcmas_simu.errors import SetcmasError


@dataclass(frozen=True)
class Communication:
    """How a fleet communicates.

    Attributes:
        graph: Who hears whom.
        channel: What happens to messages on their way.
        event_triggered: Whether robots send their state only when a condition triggers.
        seed: Chooses the random numbers of the links.
        threshold: That of the default condition in m.
    """

    graph: CommunicationGraph
    channel: Channel
    event_triggered: bool
    seed: int
    _condition: Condition = None
    threshold: float = THRESHOLD_M

    @property
    def is_ideal(self) -> bool:
        """Whether all robots know the newest pose of each other, as in the ROS 1 stack."""
        return self.reaches_all and not self.event_triggered

    @property
    def reaches_all(self) -> bool:
        """Whether each message arrives at every robot, at once and as it was."""
        return self.graph.is_complete and self.channel.is_perfect

    @property
    def needs_all_poses(self) -> bool:
        """Whether it takes the newest pose of every robot to tell who hears what."""
        return self.graph.needs_places or not self.event_triggered

    @property
    def has_default_condition(self) -> bool:
        """Whether no condition was given."""
        return self._condition is None

    @property
    def condition_script(self) -> Path | None:
        """The script of the triggering condition, if it is one."""
        condition = self._condition
        return Path(condition) if isinstance(condition, (str, Path)) else None

    def links(self, receivers: Sequence[int]) -> Links:
        """Return the links on which some robots receive the states of the fleet."""
        return Links(receivers, self.channel, self.seed)

    def broadcast(self, robot: int, reports: ErrorReports) -> Broadcast:
        """Return what decides when a robot sends its state.

        Raises:
            SetcmasError: The condition cannot be loaded.
        """
        if script := self.condition_script:
            return Broadcast.of_script(robot, script, reports)
        condition = self._condition or further_than(self.threshold)
        if isinstance(condition, Mapping):
            condition = condition[robot]
        code = getattr(condition, '__code__', None)
        return Broadcast(robot, condition, Path(code.co_filename if code else 'ctc'), reports)


def chosen_communication(
    nb_robots: int, options: CommunicationOptions | None = None, seed: int = 0
) -> Communication:
    """Return how a fleet of nb_robots communicates.

    Args:
        nb_robots: Size of the fleet.
        options: Who hears whom, when, and how badly; None is all, at once, as it was.
        seed: Chooses the random numbers of the links.

    Raises:
        SetcmasError: The graph does not suit the fleet, or there is no such condition.
    """
    chosen = options or CommunicationOptions()
    description = graph_description(chosen.graph)
    reach = math.inf if chosen.range is None else chosen.range
    return Communication(
        CommunicationGraph(description.segments(nb_robots), description.repeat, reach),
        Channel.of(nb_robots, chosen.delay, chosen.loss, chosen.noise, description.links),
        chosen.event_triggered,
        seed,
        chosen.found().ctc,
        chosen.threshold,
    )


def check_communication(options: CommunicationOptions, nb_robots: int | None) -> None:
    """See that options can be followed, before anything starts.

    Args:
        options: Those of a command.
        nb_robots: Size of the fleet, if it is known already.

    Raises:
        SetcmasError: They cannot.
    """
    condition = options.found().ctc
    if isinstance(condition, (str, Path)):
        compile_script(Path(condition), expected=CTC)
    graph_description(options.graph)
    if nb_robots is not None:
        chosen_communication(nb_robots, options)


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
        near = difflib.get_close_matches(_preset(graph), PRESETS, n=2)
        hint = f'did you mean {" or ".join(near)}? ' if near else ''
        raise SetcmasError(
            f"graph '{graph}' is unknown; {hint}it must be {', '.join(PRESETS)} or a YAML file"
        )
    return load_graph(path)


def graph_file(graph: str | Path) -> Path | None:
    """Return the file that `--graph` means, which may not exist; None if it is a preset."""
    return None if _preset(graph) in PRESETS else Path(graph)


def _preset(graph: str | Path) -> str:
    return str(graph).replace('-', '_')
