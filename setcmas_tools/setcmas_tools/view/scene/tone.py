"""Colours corrected for the tone mapping of viser's web client.

The client takes colours of lines and of batched bodies for linear light, and maps them with the
ACES filmic curve (three.js's ACESFilmicToneMapping, S. Hill's fit of the Academy Color Encoding
System's reference transforms). Uncorrected, yellow comes out beige and salmon grey.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from setcmas_simu.arrays import Floats

_INTO = np.array(
    [
        [0.59719, 0.35458, 0.04823],
        [0.07600, 0.90834, 0.01566],
        [0.02840, 0.13383, 0.83777],
    ]
)
_OUT_OF = np.array(
    [
        [1.60475, -0.53108, -0.07367],
        [-0.10208, 1.10813, -0.00605],
        [-0.00327, -0.07276, 1.07602],
    ]
)
_EXPOSURE = 1.0 / 0.6
# (v (v + a) - b) / (v (c v + d) + e)
_A, _B, _C, _D, _E = 0.0245786, 0.000090537, 0.983729, 0.4329510, 0.238081


def tone_mapped(given: ArrayLike) -> Floats:
    """Return the colours (sRGB, from 0 to 1) that the client shows where it is given these."""
    v = np.asarray(given, dtype=float) * _EXPOSURE @ _INTO.T
    v = (v * (v + _A) - _B) / (v * (_C * v + _D) + _E)
    return _srgb(np.clip(v @ _OUT_OF.T, 0.0, 1.0))


def untoned(colours: ArrayLike) -> Floats:
    """Return what to give the client for colours, so that it shows them as nearly as it can.

    Args:
        colours: Red, green, blue from 0 to 1 (sRGB), shape (..., 3); pale ones lose some of
            their brightness.
    """
    # White itself is out of reach: the brightest that comes out is the curve's value at white.
    brightest = _linear(tone_mapped(np.ones(3))).min()
    y = _linear(np.asarray(colours, dtype=float)) * brightest @ np.linalg.inv(_OUT_OF).T
    y = np.clip(y, 0.0, 1.0)
    # The curve solved for v: (c y - 1) v^2 + (d y - a) v + (e y + b) = 0.
    a, b, c = _C * y - 1.0, _D * y - _A, _E * y + _B
    v = (-b - np.sqrt(b * b - 4 * a * c)) / (2 * a)
    result: Floats = np.clip(v @ np.linalg.inv(_INTO).T / _EXPOSURE, 0.0, 1.0)
    return result


def _linear(colours: Floats) -> Floats:
    """Return linear light of sRGB values (IEC 61966-2-1)."""
    low = colours / 12.92
    result: Floats = np.where(colours <= 0.04045, low, ((colours + 0.055) / 1.055) ** 2.4)
    return result


def _srgb(light: Floats) -> Floats:
    """Return sRGB values of linear light (IEC 61966-2-1)."""
    high = 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055
    result: Floats = np.where(light <= 0.0031308, 12.92 * light, high)
    return result
