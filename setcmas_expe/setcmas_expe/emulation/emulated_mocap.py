"""Emulated motion capture: noise, latency and lost bodies."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from setcmas_expe.emulation.faults import Fault, FaultKind
from setcmas_expe.mocap.sources import Sample
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.planar_pose import quaternion_of_yaw

LATENCY_S = 0.01
"""Time from the exposure of a frame to the driver's message, in s."""

POSITION_NOISE = 2e-4
"""Standard deviation of a coordinate, in m."""

_HEADING_NOISE = 2e-3  # rad
_LATE_S = 1.0
_JUMP = 1.0  # m
_HEIGHT = 0.19  # m, of the markers on a Burger
_DRIFT = 0.3  # m/s
_LIFTED = 0.15  # m
_LIFTING = 0.3  # m/s


class EmulatedMocap:
    """Sees robots, and delays each measurement by its latency."""

    def __init__(self, nb_robots: int, y_up: bool, rng: np.random.Generator) -> None:
        """Prepare for a number of bodies; `y_up`: the y axis points upwards, not the z axis."""
        self._nb_robots = nb_robots
        self._y_up = y_up
        self._rng = rng
        self._faults: dict[tuple[FaultKind, int], tuple[float, float]] = {}  # since, until
        self._fallen: dict[int, tuple[float, float, float]] = {}  # bodies that have fallen off
        self._last: dict[int, Sample] = {}
        self._waiting: list[tuple[float, int, Sample]] = []
        self._last_due: dict[int, float] = {}

    def begin(self, fault: Fault, now: float) -> None:
        """Start a fault at time now (s); those of the robot itself change nothing here."""
        self._faults[fault.kind, fault.robot - 1] = now, now + fault.duration
        if fault.kind is FaultKind.FALLEN:
            self._fallen.pop(fault.robot - 1, None)

    def capture(self, poses: Floats, now: float) -> None:
        """Take a frame at a time (s) of true poses: rows x, y in m, theta in rad, shape (3, N)."""
        self._faults = {key: span for key, span in self._faults.items() if span[1] > now}
        sigmas = ((POSITION_NOISE,), (POSITION_NOISE,), (_HEADING_NOISE,))
        seen = self._misplaced(poses, now) + self._rng.normal(0.0, sigmas, poses.shape)
        for index, (x, y, theta) in enumerate(seen.T.tolist()):
            sample = self._spoilt(self._sample(index, now, x, y, theta), index)
            if sample:
                self._last[index] = sample
                delay = LATENCY_S + _LATE_S * self._has(FaultKind.LATE, index)
                # In order: a late measurement delays those that follow.
                self._last_due[index] = max(now + delay, self._last_due.get(index, now))
                self._waiting.append((self._last_due[index], self._name(index), sample))

    def due(self, now: float) -> list[tuple[int, Sample]]:
        """Return and forget the measurements whose latency is over at time now (s).

        Each has the index of its body, as the system names it, and is in the system's axes.
        """
        ready = [(body, sample) for at, body, sample in self._waiting if at <= now]
        self._waiting = [waiting for waiting in self._waiting if waiting[0] > now]
        return ready

    def _has(self, kind: FaultKind, index: int) -> bool:
        return (kind, index) in self._faults

    def _misplaced(self, poses: Floats, now: float) -> Floats:
        """Return where the bodies of the robots are, or seem to be, under faults."""
        poses = np.array(poses, dtype=float)
        for (kind, index), (since, _) in self._faults.items():
            x, y, theta = poses[:, index].tolist()
            if kind == FaultKind.DRIFT:
                poses[0, index] = x - math.copysign(_DRIFT * (now - since), x)
            elif kind == FaultKind.FALLEN:
                poses[:, index] = self._fallen.setdefault(index, (x, y, theta))
            elif kind == FaultKind.MIRRORED:
                poses[1:, index] = -y, -theta
            elif kind == FaultKind.TURNED:
                poses[2, index] = theta + math.pi / 2
        return poses

    def _sample(self, index: int, now: float, x: float, y: float, theta: float) -> Sample:
        if self._has(FaultKind.JUMP, index):
            x -= math.copysign(_JUMP, x)
        z, w = quaternion_of_yaw(theta)
        height = _HEIGHT
        if self._has(FaultKind.LIFT, index):
            since, _ = self._faults[FaultKind.LIFT, index]
            height += min(_LIFTED, _LIFTING * (now - since))
        if self._y_up:
            return Sample((x, height, -y), (0.0, z, 0.0, w), now)
        return Sample((x, y, height), (0.0, 0.0, z, w), now)

    def _name(self, index: int) -> int:
        """Return the body for which the system mistakes a robot."""
        following, previous = (index + 1) % self._nb_robots, (index - 1) % self._nb_robots
        if self._has(FaultKind.SWAP, index):
            return following
        return previous if self._has(FaultKind.SWAP, previous) else index

    def _spoilt(self, sample: Sample, index: int) -> Sample | None:
        """Return a measurement under the faults of its robot; None if it is not sent."""
        if self._has(FaultKind.DROPOUT, index):
            return None
        if self._has(FaultKind.FROZEN, index) and index in self._last:
            return replace(self._last[index], stamp=sample.stamp)
        if self._has(FaultKind.NAN, index):
            return replace(sample, position=(math.nan,) * 3, orientation=(math.nan,) * 4)
        return sample
