"""Proofs of which body is which robot: a crawl under motion capture, kept for 12 hours."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from setcmas_expe.lab.lab import Lab, LabRobot
from setcmas_simu.options.group import Options, flag

CRAWL_M_S = 0.05
"""Forward speed of a robot that is not proved, in m/s."""

CRAWL_RAD_S = 1.0
"""Its turn rate, in rad/s."""

PROOF_M = 0.10
"""Distance in m that proves a robot, if it goes all of it as commanded."""

_SHORTEST_TURN_S = 0.7  # time to notice a robot that moves out of its turn
_SPARE = 1.1  # for acceleration and delay


class Proving:
    """Lets unproved robots crawl in turns, so that their motions differ.

    Time is cut into turns, two for each binary digit of a robot's number: it may move in one of
    them and stands in the other. Any two robots differ in a digit, so that one stands while the
    other moves.

    Attributes:
        left: Distance in m that each unproved robot must still go, by number.
    """

    def __init__(self, robots: Iterable[int], proved: Iterable[int] = ()) -> None:
        """Start with all robots of a lab, and those among them that are proved."""
        robots = list(robots)
        self._digits = (len(robots) - 1).bit_length()
        self._turn_s = max(_SHORTEST_TURN_S, _SPARE * PROOF_M / CRAWL_M_S / max(1, self._digits))
        self._time = 0.0
        self._doubted: dict[int, bool] = {}  # whether the robot wants to go
        self.left = {robot: PROOF_M for robot in robots if robot not in set(proved)}

    def go_on(self, seconds: float) -> None:
        """Advance the time of turns, while robots are not paused."""
        self._time += seconds

    def doubt(self, robot: int) -> None:
        """Have a robot prove itself again while the others wait."""
        self.left[robot] = PROOF_M
        self._doubted[robot] = True

    @property
    def others_wait(self) -> bool:
        """Whether robots wait while a doubted one proves itself."""
        return any(self._doubted.values())

    def allowed(self, robot: int, V: float, omega: float) -> tuple[float, float]:
        """Return the part of the wanted speeds (m/s, rad/s) that a robot may drive."""
        if robot in self._doubted:
            self._doubted[robot] = V != 0.0
        elif self.others_wait:
            return 0.0, 0.0
        if robot not in self.left or not (math.isfinite(V) and math.isfinite(omega)):
            return V, omega
        if not self._has_turn(robot):
            return 0.0, 0.0
        excess = max(1.0, abs(V) / CRAWL_M_S, abs(omega) / CRAWL_RAD_S)
        return V / excess, omega / excess

    def went(self, robot: int, metres: float) -> bool:
        """Note how far a robot went as commanded (negative: back); return whether it is proved."""
        if robot not in self.left:
            return False
        self.left[robot] -= metres
        if self.left[robot] > 0.0:
            return False
        del self.left[robot]
        self._doubted.pop(robot, None)
        return True

    def _has_turn(self, robot: int) -> bool:
        if not self._digits:
            return True
        digit, half = divmod(int(self._time / self._turn_s) % (2 * self._digits), 2)
        return (robot - 1) >> digit & 1 != half


LASTING_S = 12 * 3600.0
"""How long a proof counts, in s: bodies are taken off and put on again."""


def proofs_file() -> Path:
    """Return the file of all labs of this user."""
    folder = os.environ.get('XDG_STATE_HOME') or Path.home() / '.local' / 'state'
    return Path(folder) / 'setcmas' / 'proved_bodies.yaml'


class Proofs:
    """Proofs of a lab's robots: the source, body and axes of each."""

    def __init__(self, lab: Lab, file: Path | None = None) -> None:
        """Use the user's file, or another one."""
        self._lab = lab
        self._file = file or proofs_file()

    def proved(self) -> list[int]:
        """Return the robots whose proof still counts, sorted."""
        now = time.time()
        known = self._read()
        return sorted(
            robot.number
            for robot in self._lab.robots
            if 0.0 <= now - known.get(self._key(robot), -LASTING_S) < LASTING_S
        )

    def add(self, robots: Iterable[int]) -> None:
        """Keep the proof of robots, as of now.

        Raises:
            OSError: The file cannot be written.
        """
        self._write(self._read() | {self._key(self._robot(r)): time.time() for r in robots})

    def drop(self, *robots: int) -> None:
        """Forget the proofs of robots.

        Raises:
            OSError: The file cannot be written.
        """
        known = self._read()
        dropped = {self._key(self._robot(robot)) for robot in robots}
        if dropped & known.keys():
            self._write({key: at for key, at in known.items() if key not in dropped})

    def _robot(self, number: int) -> LabRobot:
        return next(robot for robot in self._lab.robots if robot.number == number)

    def _key(self, robot: LabRobot) -> str:
        """Return the facts that a proof depends on: it ends when one of them changes."""
        mocap = self._lab.mocap
        axes = 'y up' if mocap.y_up else 'z up'
        body = f'{mocap.source.message_type} {mocap.topic_of(robot)} {robot.mocap_name} {axes}'
        return f'robot {robot.number} {robot.namespace}: {body}'

    def _read(self) -> dict[str, float]:
        try:
            known: Any = yaml.safe_load(self._file.read_text())
        except (OSError, ValueError, yaml.YAMLError):
            return {}
        if not isinstance(known, dict):
            return {}
        return {str(key): at for key, at in known.items() if isinstance(at, float)}

    def _write(self, known: dict[str, float]) -> None:
        oldest = time.time() - LASTING_S
        self._file.parent.mkdir(parents=True, exist_ok=True)
        partial = self._file.with_suffix(f'.{os.getpid()}')
        partial.write_text(yaml.safe_dump({key: at for key, at in known.items() if at > oldest}))
        partial.replace(self._file)


@dataclass(frozen=True, kw_only=True)
class ProofOptions(Options):
    """Whether proofs are used and kept."""

    emulated: bool = flag('the lab is emulated: use no earlier proofs, and keep none')

    def proofs(self, lab: Lab) -> Proofs | None:
        """Return the proofs of a lab; None in an emulated one."""
        return None if self.emulated else Proofs(lab)
