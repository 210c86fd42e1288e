"""One robot at an instant: what it did, what its law wanted, and what it knew."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from setcmas_ctrl.filter.barrier import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_simu.reports.reports import Function, ScriptFailure
from setcmas_tools.measures.motion_metrics import SATURATION_TOLERANCE, largest_speed
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.replay.knowledge import Knowledge
from setcmas_tools.replay.newest import NewestRows
from setcmas_tools.run.fleet_motion import SAME_TIME_S
from setcmas_tools.run.law_output import MOVING
from setcmas_tools.run.run import Run

Velocity = tuple[float, float]
_HELD = {
    Verdict.CHANGED: 'kept clear',
    Verdict.BLOCKED: 'blocked',
    Verdict.NO_SOLUTION: 'no solution',
}


@dataclass(frozen=True)
class RobotInstant:
    """A robot at a time; None for what is not recorded.

    Attributes:
        robot: Its number.
        t: The time in s.
        pose: x, y in m and theta in rad, in (-pi, pi]; NaN in a gap.
        speed: Along its heading in m/s.
        turn_rate: In rad/s.
        called_at: When its law was called last, in s.
        wanted: What its law then wanted after saturation: vx, vy in m/s.
        saturated: Whether that was the largest speed that robots are asked for.
        allowed: What the safety filter let through: vx, vy in m/s; None without one.
        verdict: What the filter did.
        state: What an experiment let it do, such as 'moving' or 'paused'.
        overruled: Whether the filter or the experiment did not let it do what its law wanted.
        failure: The failure of its law, if it failed then.
        known: What it then knew of the fleet: rows x, y, theta by robots' numbers from 1, NaN for
            robots that it did not hear.
        unknown: Why `known` is None.
    """

    robot: int
    t: float
    pose: tuple[float, float, float]
    speed: float
    turn_rate: float
    called_at: float | None
    wanted: tuple[float, float] | None
    saturated: bool | None
    allowed: tuple[float, float] | None
    verdict: Verdict | None
    state: str | None
    overruled: bool | None
    failure: ScriptFailure | None
    known: Floats | None
    unknown: str


class Instants:
    """Tells of robots at an instant."""

    def __init__(self, history: RunHistory) -> None:
        """Look up the run's commands."""
        self._history = history
        self._commands = history.run.commands
        commands = self._commands
        self._newest = NewestRows(commands.t, commands.robot) if commands else None
        self._knowledge = Knowledge(history)
        self._fastest = _fastest(history.run)

    def of(self, robot: int, t: float) -> RobotInstant:
        """Return a robot at a time in s."""
        history = self._history
        track, now = history.tracks[history.robots.index(robot)], np.array([t])
        x, y, theta = track.poses(now)[:, 0].tolist()
        speed, turn_rate = track.speeds(now)[:, 0].tolist()
        row = self._newest.row(robot, t) if self._newest else None
        called_at, wanted, allowed, verdict = self._command(row)
        state, held = history.safety(robot, t) or (None, None)
        changed = None if verdict is None else verdict is not Verdict.KEPT
        called = t if called_at is None else called_at
        known, unknown = self._knowledge.of(robot, called)
        return RobotInstant(
            robot=robot,
            t=t,
            pose=(x, y, float(wrap_angle(theta))),
            speed=speed,
            turn_rate=turn_rate,
            called_at=called_at,
            wanted=wanted,
            saturated=self._is_saturated(wanted),
            allowed=allowed,
            verdict=verdict,
            state=state,
            overruled=None if held is None and changed is None else bool(held or changed),
            failure=failure_at(history.run, robot, called),
            known=known,
            unknown=unknown,
        )

    def held(self, robot: int, t: float) -> str:
        """Return why a robot did not do what its law wanted, such as 'paused'; else nothing."""
        row = self._newest.row(robot, t) if self._newest else None
        called_at, _, _, verdict = self._command(row)
        failure = failure_at(self._history.run, robot, t if called_at is None else called_at)
        state, held = self._history.safety(robot, t) or (MOVING, False)
        if failure:
            where = f'{failure.script}, line {failure.line}' if failure.line else failure.script
            return f'failed: {where}'
        if state != MOVING:
            return state
        return _HELD.get(verdict, '') if verdict else 'overruled' if held else ''

    def _command(
        self, row: int | None
    ) -> tuple[float | None, Velocity | None, Velocity | None, Verdict | None]:
        """Return when a law was called, what it wanted, what was allowed, and the verdict."""
        commands = self._commands
        if commands is None or row is None:
            return None, None, None, None
        t, wanted = float(commands.t[row]), (float(commands.vx[row]), float(commands.vy[row]))
        filtered = commands.allowed
        if filtered is None:
            return t, wanted, None, None
        allowed = float(filtered.vx[row]), float(filtered.vy[row])
        return t, wanted, allowed, Verdict(int(filtered.verdict[row]))

    def _is_saturated(self, wanted: Velocity | None) -> bool | None:
        if wanted is None or self._fastest is None:
            return None
        return math.hypot(*wanted) >= self._fastest * (1 - SATURATION_TOLERANCE)


def _fastest(run: Run) -> float | None:
    try:
        return largest_speed(run)
    except SetcmasError:
        return None


def failure_at(run: Run, robot: int, t: float) -> ScriptFailure | None:
    """Return the failure of a robot's law that went on at a time in s; None if it worked."""
    end = run.info.reloads[0].t if run.info.reloads else math.inf  # another version is not told of
    for one in reversed(run.info.failures or []):
        until = end if one.until is None else one.until
        mine = one.robot == robot and one.function is Function.CONTROL
        if mine and one.t - SAME_TIME_S <= t < until - SAME_TIME_S:
            return one
    return None
