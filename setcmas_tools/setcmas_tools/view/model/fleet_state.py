"""State of a fleet: all that a display of it knows."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from setcmas_tools.view.model.communication import Flashes, Pairs
from setcmas_tools.view.model.fleet_view import FleetView
from setcmas_tools.view.model.marker_store import MarkerStore
from setcmas_tools.view.model.robot_states import RobotStates
from setcmas_tools.view.model.run_clock import RunClock

NO_PAIRS: Pairs = np.empty((0, 2), np.int64)


@dataclass
class FleetState:
    """What is known of a fleet.

    Attributes:
        announced: Numbers of the robots that there are said to be.
        models: Names of the models of robots whose model is announced.
        real: Whether this is an experiment, so that robots cannot be reset.
        ended: Whether nobody tells of robots any more; what was known last stays.
        law: The control law, as far as somebody tells.
        begun: How many runs have begun after another one.
        both: Robot numbers of communication links that go both ways, shape (E, 2).
        one_way: Of links that go one way, sender first, shape (F, 2).
    """

    fleet: FleetView = field(default_factory=FleetView)
    states: RobotStates = field(default_factory=RobotStates)
    clock: RunClock = field(default_factory=RunClock)
    markers: MarkerStore = field(default_factory=MarkerStore)
    flashes: Flashes = field(default_factory=Flashes)
    both: Pairs = field(default_factory=lambda: NO_PAIRS)
    one_way: Pairs = field(default_factory=lambda: NO_PAIRS)
    announced: list[int] = field(default_factory=list)
    models: dict[int, str] = field(default_factory=dict)
    real: bool = False
    ended: bool = False
    law: str = ''
    begun: int = 0

    def begin(self) -> None:
        """Forget the run that has ended: another one begins."""
        self.fleet, self.states, self.clock = FleetView(), RobotStates(), RunClock()
        self.markers.clear()
        self.both, self.one_way = NO_PAIRS, NO_PAIRS
        self.ended, self.law = False, ''
        self.begun += 1
