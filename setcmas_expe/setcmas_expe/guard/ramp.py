"""Ramp of a command: how soon a robot may gain speed."""

from __future__ import annotations

from setcmas_simu.robots.velocity_limits import VelocityLimits

Velocities = tuple[float, float]


def ramped(
    wanted: Velocities, before: Velocities, limits: VelocityLimits, gain: float
) -> Velocities:
    """Return the part of a command that a robot may follow now, on the same curve.

    Args:
        wanted: Forward speed in m/s and turn rate in rad/s.
        before: What it follows now.
        limits: Its largest speeds; to lose speed is never held back.
        gain: By how much a wheel may gain speed, in m/s.
    """
    V, omega = limits.scaled_down(*wanted)
    share = 1.0
    for speed, last in zip(_wheels(V, omega, limits), _wheels(*before, limits), strict=True):
        reach = gain + (abs(last) if last * speed > 0 else 0.0)
        if abs(speed) > reach:
            share = min(share, reach / abs(speed))
    return share * V, share * omega


def _wheels(V: float, omega: float, limits: VelocityLimits) -> Velocities:
    half = 0.5 * limits.wheel_separation * omega
    return V - half, V + half
