"""Proofs of which body is which robot, kept for a day in the user's folder of states."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml

from setcmas_expe.lab.model import Lab, LabRobot

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
