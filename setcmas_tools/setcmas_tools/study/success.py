"""Success of runs: an expression over the columns of a study, and the interval of its share."""

from __future__ import annotations

import ast
import difflib
import math
import re
from collections.abc import Collection, Mapping, Sequence
from statistics import NormalDist
from typing import Any

from setcmas_simu.errors import SetcmasError, needs
from setcmas_tools.measures.metric import METRICS
from setcmas_tools.study.study_columns import COLUMNS, SHIPPED

with needs('study'):
    from simpleeval import InvalidExpression, SimpleEval

CONFIDENCE = 0.95
"""Of the intervals of a share of successes."""


class Success:
    """What makes a run a success, such as 'disagreement < 0.1 and least_separation > 0.2'."""

    def __init__(self, expression: str, names: Collection[str], option: str = 'success') -> None:
        """Read the expression.

        Args:
            expression: Comparisons of numbers and columns, with and, or, not.
            names: The columns that there are.
            option: What it is called in messages.

        Raises:
            SetcmasError: It cannot be read, or names what is no column.
        """
        self.expression, self._option = expression, option
        self._evaluator = SimpleEval(functions={})
        try:
            tree = self._evaluator.parse(expression)
        except (SyntaxError, InvalidExpression, ValueError) as error:
            raise SetcmasError(
                f"{option} '{expression}' cannot be read ({error}); it must be an expression "
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


def check_columns(expression: str, names: Collection[str], option: str = 'success') -> None:
    """See that an expression can be read, and names columns that a study may have.

    Args:
        expression: The expression.
        names: What is varied.
        option: What it is called in messages.

    Raises:
        SetcmasError: It cannot, or does not.
    """
    Success(expression, [*names, *COLUMNS, *_of_plugins(expression)], option)


def _of_plugins(expression: str) -> list[str]:
    """Return the words of an expression that may be columns of a metric of a plugin."""
    own = [name for name in METRICS.offers() if name not in SHIPPED]
    words = re.findall(r'\w+', expression)
    return [word for word in words if any(word.startswith(name) for name in own)]


def _unknown(where: str, name: str, names: Collection[str]) -> str:
    near = difflib.get_close_matches(name, names, n=2)
    hint = f'did you mean {" or ".join(near)}? ' if near else ''
    return f"{where}: there is no '{name}'; {hint}it must be one of {', '.join(names)}"


def wilson(successes: int, runs: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Return the bounds of a probability of which some runs were successes.

    The score interval of Wilson, Journal of the American Statistical Association 22(158), 1927.

    Args:
        successes: Number of successes.
        runs: Number of runs, at least 1.
        confidence: Such as 0.95.
    """
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    share = successes / runs
    centre = (share + z**2 / (2 * runs)) / (1 + z**2 / runs)
    half = z / (1 + z**2 / runs) * math.sqrt(share * (1 - share) / runs + z**2 / (4 * runs**2))
    return max(0.0, centre - half), min(1.0, centre + half)


def share_of(successes: Sequence[bool]) -> tuple[float, float, float]:
    """Return the share of successes and its bounds; NaN if there is no run."""
    if not successes:
        return math.nan, math.nan, math.nan
    count = sum(successes)
    return (count / len(successes), *wilson(count, len(successes)))
