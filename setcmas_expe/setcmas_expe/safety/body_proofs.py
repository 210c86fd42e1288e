"""Proofs of which body is which robot, by a crawl under motion capture; kept for 12 hours."""

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
"""Forward speed of a robot that is not proved yet, in m/s."""

CRAWL_RAD_S = 1.0
"""Its turn rate, in rad/s."""

PROOF_M = 0.10
"""Distance in m that it must be seen to go as it is told, without any deviation."""

_SHORTEST_TURN_S = 0.7  # a robot that moves out of its turn is noticed within that
_SPARE = 1.1  # it gathers speed, and is seen late


class Proving:
    """Lets unproved robots crawl, no two of them at all the same times.

    Two unicycles that go ahead show alike, whichever is which. So time is cut into turns, two for
    each binary digit of a robot's number: it may move in one of them and stands in the other. Any
    two robots differ in a digit, hence one must stand while the other moves.

    Attributes:
        left: Distance in m that each unproved robot must still go, by number.
    """

    def __init__(self, robots: Iterable[int], proved: Iterable[int] = ()) -> None:
        """Begin with all robots of a lab, and those among them that are proved."""
        robots = list(robots)
        self._digits = (len(robots) - 1).bit_length()
        self._turn_s = max(_SHORTEST_TURN_S, _SPARE * PROOF_M / CRAWL_M_S / max(1, self._digits))
        self._time = 0.0
        self._doubted: dict[int, bool] = {}  # whether it wants to go
        self.left = {robot: PROOF_M for robot in robots if robot not in set(proved)}

    def go_on(self, seconds: float) -> None:
        """Let the time of turns go on, while robots are not paused."""
        self._time += seconds

    def doubt(self, robot: int) -> None:
        """Let a robot prove itself again, before others move: standing shows nothing."""
        self.left[robot] = PROOF_M
        self._doubted[robot] = True

    @property
    def others_wait(self) -> bool:
        """Whether robots stand because one that is doubted wants to prove itself."""
        return any(self._doubted.values())

    def allowed(self, robot: int, V: float, omega: float) -> tuple[float, float]:
        """Return the speeds (m/s, rad/s) that a robot may have of those that it wants."""
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
        """Note that a robot was seen to go some way as it was told, or back where below 0.

        Returns:
            Whether that proves it now.
        """
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
    """What has been proved of the robots of a lab: the source, body and axes of each."""

    def __init__(self, lab: Lab, file: Path | None = None) -> None:
        """Take the lab, and the file if it is not the user's."""
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
        """Keep that robots have been proved just now.

        Raises:
            OSError: The file cannot be written.
        """
        self._write(self._read() | {self._key(self._robot(r)): time.time() for r in robots})

    def drop(self, robot: int) -> None:
        """Forget the proof of a robot.

        Raises:
            OSError: The file cannot be written.
        """
        known = self._read()
        if known.pop(self._key(self._robot(robot)), None) is not None:
            self._write(known)

    def _robot(self, number: int) -> LabRobot:
        return next(robot for robot in self._lab.robots if robot.number == number)

    def _key(self, robot: LabRobot) -> str:
        """Return all that a proof is about: it does not count once any of that has changed."""
        mocap = self._lab.mocap
        axes = 'y up' if mocap.y_up else 'z up'
        body = f'{mocap.source.message_type} {mocap.topic_of(robot)} {robot.mocap_name} {axes}'
        return f'robot {robot.number} {robot.namespace}: {body}'

    def _read(self) -> dict[str, float]:
        try:
            known: Any = yaml.safe_load(self._file.read_text())
        except (OSError, ValueError, yaml.YAMLError):
            return {}  # nothing is proved by a file that cannot be read
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
    """Whether proofs count."""

    emulated: bool = flag('the lab is emulated: no proof from before counts, and none is kept')

    def proofs(self, lab: Lab) -> Proofs | None:
        """Return what was proved of a lab; None if nothing counts."""
        return None if self.emulated else Proofs(lab)
