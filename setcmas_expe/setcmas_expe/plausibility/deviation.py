"""Deviation of a robot's measured motion from what it was commanded, in a line for people."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

_STANDS = 0.4  # share of what was commanded below which nothing has moved
_BESIDE_RAD = math.radians(25)
_STILL_M = 0.02
_STILL_RAD = 0.1
_ZERO_M_S = 0.005  # what people are told as 0.00 m/s
_ZERO_RAD_S = 0.05


@dataclass(frozen=True)
class Deviation:
    """What motion capture showed over some time, and what was commanded.

    Attributes:
        seconds: How long.
        moved: Measured displacement in m: ahead, and to the left as imaginary part.
        commanded: The displacement that was commanded, likewise.
        turned: Measured turn in rad.
        commanded_turn: The turn that was commanded in rad.
        in_heading: Whether the turn deviates more than the displacement.
        rolled: Distance by the wheels' odometry in m; None if it is not known.
    """

    seconds: float
    moved: complex
    commanded: complex
    turned: float
    commanded_turn: float
    in_heading: bool
    rolled: float | None

    @property
    def is_none(self) -> bool:
        """Whether the robot stands and was told to: something was odd before, not now."""
        speed = max(abs(self.moved), abs(self.commanded)) / self.seconds
        rate = max(abs(self.turned), abs(self.commanded_turn)) / self.seconds
        return speed < _ZERO_M_S and rate < _ZERO_RAD_S

    def told(self, proved: bool) -> str:
        """Return what is wrong, and where to look; a robot that is proved has the right axes."""
        if self._stands():
            return self._standstill()
        if self.in_heading:
            return self._heading()
        wanted, got = abs(self.commanded), abs(self.moved)
        if not proved and wanted > _STILL_M and 0.5 * wanted < got < 2.0 * wanted:
            off = math.degrees(cmath.phase(self.moved / self.commanded))
            if abs(off) > math.degrees(_BESIDE_RAD):
                return (
                    f'it moves {round(off):+d} deg beside its heading: are the axes of its body, '
                    'or y_up, wrong, or is it another robot?'
                )
        return self._glides()

    def _stands(self) -> bool:
        way, turn = abs(self.commanded), abs(self.commanded_turn)
        still = abs(self.moved) <= max(_STILL_M, _STANDS * way)
        still &= abs(self.turned) <= max(_STILL_RAD, _STANDS * turn)
        return still and (way > _STILL_M or turn > _STILL_RAD)

    def _standstill(self) -> str:
        if self.rolled is None:
            where = 'has its body fallen off, or is it lifted, blocked or switched off?'
        elif self.rolled > max(_STILL_M, _STANDS * abs(self.commanded)):
            where = 'its wheels turn: has its body fallen off, or is it lifted or blocked?'
        else:
            where = 'its wheels stand too: is it blocked, or its motors off?'
        return f'it stands although it is told to move; {where}'

    def _heading(self) -> str:
        rates = (self.turned / self.seconds, self.commanded_turn / self.seconds)
        if self.turned * self.commanded_turn < 0 and abs(self.turned) > _STILL_RAD:
            return (
                f'it turns at {rates[0]:+.1f} rad/s, told {rates[1]:+.1f}: are axes mirrored '
                '(y_up in the lab file), or is it another robot?'
            )
        return (
            f'it turns at {rates[0]:+.1f} rad/s, told {rates[1]:+.1f}: is its body symmetric or '
            'loose, or is it turned by hand?'
        )

    def _glides(self) -> str:
        speed, told = abs(self.moved) / self.seconds, abs(self.commanded) / self.seconds
        wheels = '' if self.rolled is None else f', its wheels {self.rolled / self.seconds:.2f}'
        return (
            f'it moves at {speed:.2f} m/s, told {told:.2f}{wheels}: does motion capture drift, or '
            'is it pushed?'
        )
