"""One pose of motion capture, turned Z-up and checked on its own; velocities from several."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace

from setcmas_simu.fleet.planar_pose import wrap_angle, yaw_of_quaternion
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.unicycle import velocities_between

_TIME_CONSTANT_S = 0.1
_SHORTEST_STEP_S = 1e-3
_LONGEST_STEP_S = 1.0


class VelocityFilter:
    """Estimates forward speed and turn rate of one robot.

    Backward differences through a first-order low-pass filter, exact for any step (Astrom and
    Wittenmark, Computer-Controlled Systems, 1997, section 2.3).
    """

    def __init__(self) -> None:
        self._last: tuple[float, Pose] = -math.inf, (0.0, 0.0, 0.0)
        self._V = self._omega = 0.0

    def update(self, sample: Sample, now: float) -> tuple[float, float]:
        """Return speed (m/s) and turn rate (rad/s) at a measurement that arrived `now` (s)."""
        time, pose = sample.stamp or now, sample.planar()
        step = time - self._last[0]
        if 0.0 <= step < _SHORTEST_STEP_S:  # a repeated stamp
            return self._V, self._omega
        if 0.0 <= step <= _LONGEST_STEP_S:
            V, omega = map(float, velocities_between(self._last[1], pose, step))
            share = 1.0 - math.exp(-step / _TIME_CONSTANT_S)
            self._V += share * (V - self._V)
            self._omega += share * (omega - self._omega)
        else:  # a gap, or a clock that was set
            self._V = self._omega = 0.0
        self._last = time, pose
        return self._V, self._omega


Pose = tuple[float, float, float]


def motion_between(old: Pose, new: Pose) -> tuple[float, float]:
    """Return how far in m, and by which angle from 0 to pi rad, two poses are apart."""
    return math.dist(old[:2], new[:2]), abs(float(wrap_angle(new[2] - old[2])))


class PoseFault(enum.Enum):
    """Why a measurement is rejected; the values are texts for people."""

    NOT_FINITE = 'not a number'
    ZERO = 'exactly zero'
    NO_ROTATION = 'orientation that is not a unit quaternion'
    TILTED = 'tilted (has the robot fallen over, or is y_up wrong in the lab file?)'
    FAR_AWAY = 'far outside the arena'
    JUMPED = 'it jumped (was it carried, or were names swapped? Pause for a second, then start)'
    LIFTED = 'it was lifted'
    STAMPS = 'its stamps do not change: correct the motion capture clock, or send no stamps'


_FAR_M = 1.0  # from the arena
_MILLIMETRES = 20.0  # m: a room is smaller
_NORM_TOLERANCE = 0.02
_LARGEST_TILT = math.radians(45)


@dataclass(frozen=True)
class Sample:
    """One measurement by a driver.

    Attributes:
        position: x, y, z in m.
        orientation: Quaternion x, y, z, w.
        stamp: Time of the measurement on the driver's clock in s; 0 if not set.
    """

    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    stamp: float = 0.0

    def z_up(self) -> Sample:
        """Return a measurement in Y-up axes (of world and body) in Z-up axes.

        A quarter turn about x takes (x, y, z), and the vector part of a quaternion, to (x, -z, y).
        """
        x, y, z = self.position
        qx, qy, qz, qw = self.orientation
        return replace(self, position=(x, -z, y), orientation=(qx, -qz, qy, qw))

    def planar(self) -> Pose:
        """Return x, y in m and the heading in rad."""
        return (*self.position[:2], yaw_of_quaternion(*self.orientation))


def fault_of(sample: Sample, arena: Arena) -> PoseFault | None:
    """Return the fault of a measurement on its own; None if it is good."""
    x, y, _ = sample.position
    if not all(map(math.isfinite, (*sample.position, *sample.orientation))):
        return PoseFault.NOT_FINITE
    if not any(sample.position):
        return PoseFault.ZERO
    if abs(math.hypot(*sample.orientation) - 1.0) > _NORM_TOLERANCE:
        return PoseFault.NO_ROTATION
    if _tilt(sample.orientation) > _LARGEST_TILT:
        return PoseFault.TILTED
    return PoseFault.FAR_AWAY if arena.distance(x, y) > _FAR_M else None


def text_of(fault: PoseFault, sample: Sample, arena: Arena) -> str:
    """Return why a measurement is rejected, with numbers where they help."""
    if fault is not PoseFault.FAR_AWAY:
        return str(fault.value)
    x, y, _ = sample.position
    in_mm = arena.distance(x / 1000, y / 1000) == 0 and max(abs(x), abs(y)) > _MILLIMETRES
    hint = '; does motion capture send millimetres? It must send metres' if in_mm else ''
    return f'at x = {x:.1f} m, y = {y:.1f} m, {fault.value}{hint}'


def _tilt(orientation: tuple[float, float, float, float]) -> float:
    """Return the angle in rad between the body's z axis and the vertical."""
    qx, qy, qz, qw = orientation
    norm = qx * qx + qy * qy + qz * qz + qw * qw
    cosine = (qw * qw + qz * qz - qx * qx - qy * qy) / norm
    return math.acos(max(-1.0, min(1.0, cosine)))
