"""Likeness of submissions: how much of a syntax tree is in another one, whatever names it uses.

Names, layout and comments do not count, nor does what the exercise had given. Source of comparing
by overlapping runs: Schleimer, Wilkerson and Aiken, "Winnowing", SIGMOD 2003.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice

from setcmas_tools.grade.marks import Similar

_RUN = 8  # nodes of a syntax tree that are compared at once
_MOST_NODES = 20_000  # of a script
_LIKE = 0.8
_FEWEST = 30  # below so many runs of nodes all solutions are alike
_UNREADABLE = (SyntaxError, ValueError, RecursionError, MemoryError)

Print = frozenset[tuple[str, ...]]


def fingerprint(sources: Iterable[bytes], given: Print = frozenset()) -> Print:
    """Return what a submission is compared by.

    Args:
        sources: Its scripts.
        given: What all had from the beginning.
    """
    runs: set[tuple[str, ...]] = set()
    for source in sources:
        try:
            nodes = list(islice(_nodes(ast.parse(source)), _MOST_NODES))
        except _UNREADABLE:
            continue
        runs |= {tuple(nodes[i : i + _RUN]) for i in range(len(nodes) - _RUN + 1)}
    return frozenset(runs - given)


def likenesses(own: Mapping[str, Print], known: Mapping[str, Print]) -> dict[str, list[Similar]]:
    """Return what each submission is like, the most alike first.

    Args:
        own: The submissions by their names.
        known: Other scripts by what they are to be called.
    """
    found: dict[str, list[Similar]] = {name: [] for name in own}
    for name, runs in own.items():
        others = {**known, **{other: one for other, one in own.items() if other != name}}
        for other, theirs in others.items():
            if (share := _share(runs, theirs)) >= _LIKE:
                found[name].append(Similar(other, round(share, 2)))
        found[name].sort(key=lambda one: (-one.share, one.submission))
    return found


def _share(own: Print, theirs: Print) -> float:
    """Return how much two have in common, as a share of all that they have."""
    if min(len(own), len(theirs)) < _FEWEST:
        return 0.0
    return len(own & theirs) / len(own | theirs)


def _nodes(tree: ast.AST) -> Iterator[str]:
    """Yield the nodes of a tree in order, without names and docstrings."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if not isinstance(node, (ast.expr_context, ast.Import, ast.ImportFrom)):
            yield repr(node.value) if isinstance(node, ast.Constant) else type(node).__name__
            yield from _nodes(node)
