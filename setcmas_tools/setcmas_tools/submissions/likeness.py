"""Similarity of submissions: the share of a syntax tree found in another, whatever the names.

Names, layout, comments and the given parts of the exercise do not count. Comparison by
overlapping runs: Schleimer, Wilkerson and Aiken, "Winnowing", SIGMOD 2003.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

from setcmas_ctrl.laws.script_search import UNREADABLE

_RUN = 8  # syntax tree nodes per compared run
_MOST_NODES = 20_000  # per script
_LIKE = 0.8
_FEWEST = 30  # with fewer runs of nodes, all solutions are similar

Print = frozenset[tuple[str, ...]]


@dataclass(frozen=True)
class Similar:
    """Another submission, or 'the built-in law NAME', and its similarity, from 0 to 1."""

    submission: str
    share: float


def fingerprint(sources: Iterable[bytes], given: Print = frozenset()) -> Print:
    """Return the fingerprint of a submission's scripts without that of the given parts."""
    runs: set[tuple[str, ...]] = set()
    for source in sources:
        try:
            nodes = list(islice(_nodes(ast.parse(source)), _MOST_NODES))
        except UNREADABLE:
            continue
        runs |= {tuple(nodes[i : i + _RUN]) for i in range(len(nodes) - _RUN + 1)}
    return frozenset(runs - given)


def likenesses(own: Mapping[str, Print], known: Mapping[str, Print]) -> dict[str, list[Similar]]:
    """Return the scripts similar to each submission, among these and other known scripts.

    The fingerprints are by name; the most similar scripts are first.
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
    """Return the common share of two fingerprints."""
    if min(len(own), len(theirs)) < _FEWEST:
        return 0.0
    return len(own & theirs) / len(own | theirs)


def _nodes(tree: ast.AST) -> Iterator[str]:
    """Yield the nodes of a tree in order, without names and docstrings.

    A tree may be nested more deeply than functions may call themselves.
    """
    left = [tree]
    while left:
        node = left.pop()
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, (ast.expr_context, ast.Import, ast.ImportFrom)):
            continue
        if node is not tree:
            yield repr(node.value) if isinstance(node, ast.Constant) else type(node).__name__
        left += reversed([*ast.iter_child_nodes(node)])
