"""Options of a fleet's communication, and the graph, links and triggers that they choose."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from setcmas_ctrl.communication.delay_and_loss import Channel, Links
from setcmas_ctrl.communication.graph import (
    COMPLETE,
    PRESETS,
    CommunicationGraph,
    Graph,
    graph_description,
)
from setcmas_ctrl.communication.triggering_conditions import (
    CTC,
    THRESHOLD_M,
    Broadcast,
    further_than,
)
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_ctrl.laws.script_function import file_of
from setcmas_ctrl.laws.script_loader import CONDITIONS, compile_script, load_script
from setcmas_ctrl.laws.script_search import find_script, unfilled_note
from setcmas_simu.option_groups import ClashError, Options, flag, option
from setcmas_simu.option_kinds import LENGTH, Number, OneOf, ScriptOrFunction

HELD, EXACT = 'held', 'exact'
"""What an event-triggered robot's law sees of its own state: the last one sent, or the newest."""

Condition = str | Path | Callable[..., Any] | Mapping[int, Callable[..., Any]] | None


@dataclass(frozen=True)
class _Graph(ScriptOrFunction):
    """A name or a file; in Python also a matrix."""

    def located(self, value: Any, place: Callable[[str], str]) -> Any:
        names_file = isinstance(value, str) and ('.' in value or '/' in value)
        return place(value) if names_file else value


@dataclass(frozen=True, kw_only=True)
class CommunicationOptions(Options):
    """Graph, event triggering, and quality of the links."""

    TITLE: ClassVar[str] = 'communication (default: all robots know all poses)'

    event_triggered: bool = flag('robots send their state only when a condition holds')
    ctc: Condition = option(
        ScriptOrFunction(metavar='NAME'),
        'triggering condition: a path or the name of a script with ctc(pos, last_pos, t), or one '
        'of the literature (see setcmas list)',
        default=None,
        default_text='send when farther than --threshold from the last position sent',
    )
    threshold: float = option(
        LENGTH,
        'without --ctc: how far a robot moves from the last position sent before it sends again',
        default=THRESHOLD_M,
    )
    own_state: str = option(
        OneOf((HELD, EXACT)),
        f'which pose of its own robot a law gets with --event-triggered: the last one sent '
        f'({HELD}), as for the others, or the current one ({EXACT})',
        default=HELD,
    )
    graph: Graph = option(
        _Graph(metavar='NAME|FILE.yaml', choices=tuple(PRESETS)),
        f'communication graph: {", ".join(PRESETS)}, or a file',
        default=COMPLETE,
    )
    range: float | None = option(
        Number(above=0, unit='m'), 'robots farther apart than this have no link', default=None
    )
    delay: float = option(
        Number(least=0, unit='s', finite=True), 'delay of each message', default=0.0
    )
    loss: float = option(
        Number(least=0, most=1, metavar='P'), 'probability that a message is lost', default=0.0
    )
    noise: float = option(
        Number(least=0, unit='m', finite=True),
        'standard deviation of the noise added to received positions',
        default=0.0,
    )

    def check(self) -> None:
        """Check that options of event-triggered robots have an effect."""
        changed = self.changed()
        for name in ('ctc', 'threshold', 'own_state'):
            if name in changed and not self.event_triggered:
                raise ClashError('{} needs {}; add it', name, 'event_triggered')
        if self.threshold != THRESHOLD_M and self.ctc is not None:
            raise ClashError('{} has its own threshold; remove {}', 'ctc', 'threshold')

    def found(self, exercise: bool = False) -> CommunicationOptions:
        """Return the same with the file that `ctc` names, or raise SetcmasError."""
        if not isinstance(self.ctc, (str, Path)):
            return self
        path = find_script(str(self.ctc), exercise, (CONDITIONS,), '--ctc', CTC)
        return replace(self, ctc=path)

    @property
    def notes(self) -> list[str]:
        """Notes for the user: a condition that is not filled in yet, or nothing arrives."""
        unfilled = unfilled_note(self.ctc) if isinstance(self.ctc, Path) else ''
        silent = 'loss is 1: no message arrives, so robots know only where the others started'
        return [note for note in (unfilled, silent if self.loss == 1.0 else '') if note]


@dataclass(frozen=True)
class Communication:
    """Communication of a fleet.

    Attributes:
        graph: Which robots receive from which.
        options: What was chosen, with the path of a condition that is a script.
        seed: Seed of the links' random numbers.
    """

    graph: CommunicationGraph
    options: CommunicationOptions
    seed: int

    @property
    def event_triggered(self) -> bool:
        """Whether robots send their state only when a condition holds."""
        return self.options.event_triggered

    @property
    def is_ideal(self) -> bool:
        """Whether all robots know all newest poses, as in the ROS 1 stack."""
        return self.reaches_all and not self.event_triggered

    @property
    def channel(self) -> Channel:
        """Delay, loss and noise of the links."""
        return Channel(self.options.delay, self.options.loss, self.options.noise)

    @property
    def reaches_all(self) -> bool:
        """Whether each message reaches every robot at once and unchanged."""
        return self.graph.is_complete and self.channel == Channel()

    @property
    def needs_all_poses(self) -> bool:
        """Whether the links depend on the newest pose of every robot."""
        return self.graph.needs_places or not self.event_triggered

    @property
    def condition_script(self) -> Path | None:
        """Script of the triggering condition; None if it is no script."""
        return self.options.ctc if isinstance(self.options.ctc, Path) else None

    def links(self, receivers: Sequence[int]) -> Links:
        """Return the links on which some robots receive the states of the fleet."""
        holds_own = self.event_triggered and self.options.own_state == HELD
        return Links(receivers, self.graph.nb_robots, self.channel, self.seed, holds_own)

    def broadcast(self, robot: int, reports: ErrorReports) -> Broadcast:
        """Return the object that decides when a robot sends its state, or raise SetcmasError."""
        if script := self.condition_script:
            condition = vars(load_script(script, robot, CTC)).get('ctc')
            return Broadcast(robot, condition, script, reports)
        condition = self.options.ctc or further_than(self.options.threshold)
        if isinstance(condition, Mapping):
            condition = condition[robot]
        return Broadcast(robot, condition, file_of(condition, 'ctc'), reports)


def chosen_communication(
    nb_robots: int, options: CommunicationOptions | None = None, seed: int = 0
) -> Communication:
    """Return the communication of a fleet, ideal by default, or raise SetcmasError."""
    chosen = (options or CommunicationOptions()).found()
    description = graph_description(chosen.graph)
    reach = math.inf if chosen.range is None else chosen.range
    return Communication(
        CommunicationGraph(description.segments(nb_robots), description.repeat, reach),
        chosen,
        seed,
    )


def check_communication(options: CommunicationOptions, nb_robots: int | None) -> None:
    """Check options, also for a fleet of unknown size, or raise SetcmasError."""
    condition = options.found().ctc
    if isinstance(condition, (str, Path)):
        compile_script(Path(condition), expected=CTC)
    graph_description(options.graph)
    if nb_robots is not None:
        chosen_communication(nb_robots, options)
