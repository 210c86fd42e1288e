"""Predictions of laws: functions of a law and of conditions, found by the name of the law."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace
from typing import Any

from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_ctrl.predictions.conditions import Conditions, Theorem
from setcmas_ctrl.predictions.linear_law import LinearLaw
from setcmas_simu.errors import SetcmasError
from setcmas_simu.plugins import InvalidPluginError, PluginGroup


@dataclass(frozen=True)
class Prediction:
    """What theory says of a run.

    Attributes:
        linear: The law of all robots together, if it is linear.
        theorems: Further figures.
    """

    linear: LinearLaw | None = None
    theorems: tuple[Theorem, ...] = ()


Predict = Callable[[Any, Conditions], Prediction]
"""Predicts runs of a law: gets its script, such as `law.K`, and the conditions."""


def _function(thing: object) -> Predict:
    if not callable(thing):
        raise InvalidPluginError(
            f'it is a {type(thing).__name__}; it must be a function of a law and of conditions'
        )
    return thing


_MOST_ROBOTS = 300
"""Larger fleets are not predicted: their eigenvalues would take seconds."""

PREDICTIONS = PluginGroup('setcmas.predictions', 'prediction', _function)
"""Predictions of the laws of installed packages, by the name of the law."""


@cache
def predicted_law(script: bytes) -> str | None:
    """Return the name of the law of a package with this text; None if it has no predictions."""
    for name in PREDICTIONS.plugins():
        try:
            if ALGORITHMS.file(name).read_bytes() == script:
                return name
        except SetcmasError:  # that of another package is damaged
            continue
    return None


def predicted(name: str, law: Mapping[str, Any], conditions: Conditions) -> Prediction:
    """Return what theory says of a run; nothing of more than 300 robots.

    Args:
        name: Name of the law.
        law: The top-level names of its loaded script, with their values.
        conditions: Those of the run.

    Raises:
        SetcmasError: The prediction cannot be imported.
        InvalidPluginError: It returns something else.
    """
    if len(conditions.adjacency) > _MOST_ROBOTS:
        return Prediction()
    result = PREDICTIONS.get(name)(SimpleNamespace(**law), conditions)
    if not isinstance(result, Prediction):
        raise InvalidPluginError(
            f'of {PREDICTIONS.plugin(name).title} returned a {type(result).__name__}; it must '
            'return a Prediction'
        )
    return result
