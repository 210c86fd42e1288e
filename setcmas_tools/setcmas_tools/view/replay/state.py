"""State of a fleet at a time of a run that is over."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import wrap_angle
from setcmas_tools.replay.history import RunHistory
from setcmas_tools.replay.instant import Instants
from setcmas_tools.run.run import models_of
from setcmas_tools.view.fleet_drawing import Placed
from setcmas_tools.view.model.communication import FLASH_S, Flashes, links
from setcmas_tools.view.model.fleet_state import FleetState
from setcmas_tools.view.model.fleet_view import LOST_S, FleetView
from setcmas_tools.view.model.robot_states import ERROR, WARN, RobotStates
from setcmas_tools.view.model.run_clock import RunClock
from setcmas_tools.view.replay.drawings import ReplayedDrawings


class _Fleet(FleetView):
    """The robots at a time, each where it was, or where it was seen last."""

    def __init__(self, history: RunHistory) -> None:
        super().__init__()
        self._history = history
        self._t = history.t0
        self.move_to(history.t0, history.t0)

    def move_to(self, t: float, since: float) -> None:
        """Show a time in s; robots that were put somewhere since another one are told of."""
        history = self._history
        self._t, self._put = t, self._put | history.put(since, t)
        newest, poses, speeds = history.newest(t), history.poses(t), history.speeds(t)[0]
        there = np.isfinite(newest[0])
        shown = np.where(np.isfinite(poses), poses, newest)[:, there]
        shown[2] = wrap_angle(shown[2])
        self._robots = [robot for robot, yes in zip(history.robots, there, strict=True) if yes]
        self._poses: Floats = shown
        self._speeds: Floats = np.nan_to_num(speeds[there])

    @property
    def robots(self) -> list[int]:
        return self._robots

    def poses(self, now: float) -> Floats:
        del now
        return self._poses

    def newest(self) -> Floats:
        return self._poses

    def speeds(self) -> Floats:
        return self._speeds

    def lost(self, now: float) -> NDArray[np.bool_]:
        del now
        both = zip(self._history.robots, self._history.tracks, strict=True)
        tracks = [track for robot, track in both if robot in self._robots]
        ages = [self._t - track.rows.t[track.newest(self._t)] for track in tracks]
        return np.array(ages) > LOST_S

    def forget(self, now: float) -> None:
        del now


class _States(RobotStates):
    def __init__(self, instants: Instants) -> None:
        super().__init__()
        self._instants = instants

    def describe(self, robot: int, lost: bool, speed: float, now: float) -> tuple[int, str]:
        held = '' if lost else self._instants.held(robot, now)
        if held:
            return (ERROR if held.startswith('failed') else WARN), held
        return super().describe(robot, lost, speed, now)


class _Clock(RunClock):
    """The time of the run, and what is said of it."""

    said = ''

    def describe(self, now: float) -> str:
        del now
        return self.said

    def seconds(self, now: float) -> float | None:
        return now


class _Flashes(Flashes):
    def __init__(self, history: RunHistory) -> None:
        super().__init__()
        self._history = history
        self.speed = 1.0

    def strength(self, robots: list[int], now: float) -> Floats:
        ages = dict(zip(self._history.robots, self._history.broadcast_ages(now), strict=True))
        lasts = FLASH_S * max(1.0, self.speed)
        result: Floats = np.clip(1.0 - np.array([ages[r] for r in robots]) / lasts, 0.0, 1.0)
        return result


class ReplayedState(FleetState):
    """What was known of a fleet at a time.

    Attributes:
        history: The run at any time.
        instants: One robot at any time.
    """

    def __init__(self, history: RunHistory) -> None:
        """Begin at the begin."""
        run = history.run
        self.history, self.instants = history, Instants(history)
        self._fleet, self._clock = _Fleet(history), _Clock()
        self._flashes, self._t = _Flashes(history), history.t0
        super().__init__(
            fleet=self._fleet,
            states=_States(self.instants),
            clock=self._clock,
            flashes=self._flashes,
            models=models_of(run),
            real=run.tables.safety is not None,
            law=str(run.parameters.get('script') or run.parameters.get('algo') or ''),
        )
        self._drawings = ReplayedDrawings(history, self.markers)
        self.move_to(history.t0)

    def move_to(self, t: float, said: str = '', speed: float = 1.0) -> None:
        """Show a time.

        Args:
            t: The time in s.
            said: What is said of it in the panel.
            speed: How many times as fast as it was it is shown: flashes last as long to the eye.
        """
        self._fleet.move_to(t, min(t, self._t))
        self._t = t
        self.ended = t > self.history.t1
        self._clock.said, self._flashes.speed = said, speed
        adjacency = self.history.adjacency(t)
        if adjacency is not None:
            self.both, self.one_way = links(adjacency)
        self._drawings.show(t)

    def past(self, length_s: float) -> Iterator[Placed]:
        """Yield where robots were in the last seconds, one after the other."""
        times, xy = self.history.trails(self._t, length_s)
        robots = self.fleet.robots
        xy = xy[:, :, [self.history.robots.index(robot) for robot in robots]]
        known = np.isfinite(xy[:, 0])
        steps = np.arange(len(times))[:, None]
        last = np.maximum.accumulate(np.where(known, steps, -1), axis=0)
        last = np.where(last < 0, known.argmax(axis=0), last)
        filled = np.take_along_axis(xy, last[:, None], axis=0)
        breaks = bool(self.history.put(times[0], self._t))
        before = times[0]
        for t, positions in zip(times.tolist(), filled, strict=True):
            put = self.history.put(before, t) if breaks else set()
            before = t
            if np.isfinite(positions).all():
                yield t, robots, positions, put
