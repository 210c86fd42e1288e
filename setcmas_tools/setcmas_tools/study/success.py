"""Success of runs: an expression over the columns of a study, and the interval of its rate."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Collection, Mapping, Sequence
from statistics import NormalDist
from typing import Any

from setcmas_simu.errors import SetcmasError, did_you_mean, needs
from setcmas_tools.measures.metric import METRICS
from setcmas_tools.study.study_columns import COLUMNS, SHIPPED

with needs('study'):
    from simpleeval import InvalidExpression, SimpleEval

CONFIDENCE = 0.95
"""Confidence of the intervals of success rates."""


class Success:
    """Condition for a success, such as 'disagreement < 0.1 and least_separation > 0.2'."""

    def __init__(self, expression: str, names: Collection[str], option: str = 'success') -> None:
        """Read the expression.

        Args:
            expression: Comparisons of numbers and columns, with and, or, not.
            names: Known columns.
            option: Name of the option in messages.

        Raises:
            SetcmasError: The expression is invalid, or has an unknown column.
        """
        self.expression, self._option = expression, option
        self._evaluator = SimpleEval(functions={})
        try:
            tree = self._evaluator.parse(expression)
        except (SyntaxError, InvalidExpression, ValueError) as error:
            raise SetcmasError(
                f"invalid {option} '{expression}' ({error}); must be an expression "
                "such as 'disagreement<0.1 and least_separation>0.2'"
            ) from error
        self._tree = tree
        for node in ast.walk(tree):
            if isinstance(node, ast.Name) and node.id not in names:
                raise SetcmasError(_unknown(f"{option} '{expression}'", node.id, names))

    def of(self, row: Mapping[str, Any]) -> bool:
        """Return whether a run is a success; comparisons with NaN are false.

        Raises:
            SetcmasError: The expression has no value.
        """
        self._evaluator.names = dict(row)
        try:
            return bool(self._evaluator.eval(self.expression, previously_parsed=self._tree))
        except (InvalidExpression, ArithmeticError, TypeError, ValueError) as error:
            raise SetcmasError(f"{self._option} '{self.expression}': {error}") from error


def check_columns(
    expression: str, names: Collection[str], metrics: Collection[str] = (), option: str = 'success'
) -> None:
    """Check that an expression is valid, and only has columns that the study may have.

    Args:
        expression: The expression.
        names: Varied names.
        metrics: Names of further metrics.
        option: Name of the option in messages.

    Raises:
        SetcmasError: The expression is invalid.
    """
    known = [name for name in METRICS.plugins() if name not in SHIPPED]
    words = re.findall(r'\w+', expression)
    others = [word for word in words if word.startswith((*known, *metrics))]
    Success(expression, [*names, *COLUMNS, *others], option)


def _unknown(where: str, name: str, names: Collection[str]) -> str:
    hint = did_you_mean(name, names, 2)
    return f"{where}: unknown column '{name}'; must be one of {', '.join(names)}{hint}"


def wilson(successes: int, runs: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return the confidence bounds of a success probability.

    The score interval of Wilson, Journal of the American Statistical Association 22(158), 1927.

    Args:
        successes: Number of successes.
        runs: Number of runs, at least 1.
        confidence: For example 0.95.
    """
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    share = successes / runs
    centre = (share + z**2 / (2 * runs)) / (1 + z**2 / runs)
    half = z / (1 + z**2 / runs) * math.sqrt(share * (1 - share) / runs + z**2 / (4 * runs**2))
    return max(0.0, centre - half), min(1.0, centre + half)


def share_of(successes: Sequence[bool]) -> tuple[float, float, float]:
    """Return the success rate and its bounds; NaN without runs."""
    if not successes:
        return math.nan, math.nan, math.nan
    count = sum(successes)
    return (count / len(successes), *wilson(count, len(successes)))
