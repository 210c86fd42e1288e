"""Findings of checks: their table, advice and verdict."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass

from tabulate import tabulate

OK = 'ok'
NOTE = 'note'
PROBLEM = 'PROBLEM'

_WIDTH = 99


@dataclass(frozen=True)
class Finding:
    """The outcome of one check.

    Attributes:
        level: OK, NOTE (works, with a remark) or PROBLEM (does not work).
        what: Subject of the check.
        advice: What to do; empty if nothing.
    """

    level: str
    what: str
    found: str
    advice: str = ''


def table(findings: Iterable[Finding]) -> str:
    """Return a table with a line for each finding."""
    rows = [(finding.level, finding.what, finding.found) for finding in findings]
    table: str = tabulate(rows, tablefmt='plain', disable_numparse=True)
    return table


def advice_lines(findings: Iterable[Finding]) -> list[str]:
    """Return the advice, problems first, each once, wrapped to the width of a terminal."""
    subjects: dict[str, list[str]] = {}
    for finding in sorted(findings, key=lambda finding: finding.level != PROBLEM):
        if finding.advice:
            subjects.setdefault(finding.advice, []).append(finding.what)
    wrapper = textwrap.TextWrapper(
        _WIDTH,
        initial_indent='- ',
        subsequent_indent='  ',
        break_long_words=False,
        break_on_hyphens=False,
    )
    lines = []
    for advice, whats in subjects.items():
        lines += wrapper.wrap(f'{", ".join(dict.fromkeys(whats))}: {advice}')
    return lines


def verdict(findings: Iterable[Finding]) -> str:
    """Return the verdict over all findings in one line."""
    levels = [finding.level for finding in findings]
    problems, notes = levels.count(PROBLEM), levels.count(NOTE)
    if problems:
        return f'{problems} problem{"s" * (problems > 1)}: see what to do above'
    return 'all well' + (f', with {notes} note{"s" * (notes > 1)}' if notes else '')


def exit_status(findings: Iterable[Finding]) -> int:
    """Return 0 if there is no problem, else 1."""
    return int(any(finding.level == PROBLEM for finding in findings))
