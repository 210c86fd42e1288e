"""Settings of communication: graph, event triggering, channels."""

from __future__ import annotations

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
from setcmas_simu.errors import SetcmasError, did_you_mean


@dataclass(frozen=True)
class Communication:
    """Communication of a fleet.

    Attributes:
        graph: Who hears whom.
        channel: Delay, loss and noise of the links.
        event_triggered: Whether robots send their state only when a condition triggers.
        seed: Seed of the links' random numbers.
        threshold: Threshold of the default condition in m.
    """

    graph: CommunicationGraph
    channel: Channel
    event_triggered: bool
    seed: int
    _condition: Condition = None
    threshold: float = THRESHOLD_M

    @property
    def is_ideal(self) -> bool:
        """Whether all robots know all newest poses, as in the ROS 1 stack."""
        return self.reaches_all and not self.event_triggered

    @property
    def reaches_all(self) -> bool:
        """Whether each message reaches every robot at once and unchanged."""
        return self.graph.is_complete and self.channel.is_perfect

    @property
    def needs_all_poses(self) -> bool:
        """Whether the links depend on the newest pose of every robot."""
        return self.graph.needs_places or not self.event_triggered

    @property
    def has_default_condition(self) -> bool:
        """Whether no condition was given."""
        return self._condition is None

    @property
    def condition_script(self) -> Path | None:
        """Script of the triggering condition; None if it is no script."""
        condition = self._condition
        return Path(condition) if isinstance(condition, (str, Path)) else None

    def links(self, receivers: Sequence[int]) -> Links:
        """Return the links on which some robots receive the states of the fleet."""
        return Links(receivers, self.channel, self.seed)

    def broadcast(self, robot: int, reports: ErrorReports) -> Broadcast:
        """Return the object that decides when a robot sends its state.

        Raises:
            SetcmasError: The condition does not load.
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
    """Return the communication of a fleet of nb_robots.

    Args:
        nb_robots: Size of the fleet.
        options: Options of a command; None is ideal communication.
        seed: Seed of the links' random numbers.

    Raises:
        SetcmasError: The graph does not suit the fleet, or the condition does not exist.
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
    """Check options of communication before anything starts.

    Args:
        options: Options of a command.
        nb_robots: Size of the fleet, if known.

    Raises:
        SetcmasError: An option is invalid.
    """
    condition = options.found().ctc
    if isinstance(condition, (str, Path)):
        compile_script(Path(condition), expected=CTC)
    graph_description(options.graph)
    if nb_robots is not None:
        chosen_communication(nb_robots, options)


def graph_description(graph: Graph) -> GraphDescription:
    """Return the graph of a preset's name, a graph file or an adjacency matrix.

    Raises:
        SetcmasError: The preset or file does not exist, or the file is malformed.
    """
    if not isinstance(graph, (str, Path)):
        build = partial(checked_adjacency, graph)
        return GraphDescription(False, [], [('', math.inf, build)])
    path = graph_file(graph)
    if path is None:
        name = _preset(graph)
        return GraphDescription(False, [], [(name, math.inf, PRESETS[name])])
    if path.suffix not in ('.yaml', '.yml') and not path.is_file():
        known = f'{", ".join(PRESETS)} or a YAML file{did_you_mean(_preset(graph), PRESETS, 2)}'
        raise SetcmasError(f"unknown graph '{graph}'; it must be {known}")
    return load_graph(path)


def graph_file(graph: str | Path) -> Path | None:
    """Return the file in `--graph`, whether or not it exists; None for a preset."""
    return None if _preset(graph) in PRESETS else Path(graph)


def _preset(graph: str | Path) -> str:
    return str(graph).replace('-', '_')
