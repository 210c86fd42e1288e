"""Verdict on a simulation and an experiment, as a table and in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tabulate import tabulate

from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.comparison.verdict import PART_M, Reached, Verdict

_UNKNOWN = '-'
_HEADS = (
    'experiment', 'parts at (s)', 'RMS (m)', 'later by (s)', 'top speed (m/s)',
    'top turn (rad/s)', 'stopped (s)', 'messages lost',
)  # fmt: skip


def verdict_table(found: Mapping[int, Verdict], form: str = 'simple') -> str:
    """Return a row for each robot, in a format of tabulate; - stands for what is not known."""
    rows = [[robot_name(robot), *_cells(one)] for robot, one in found.items()]
    align = ('left', *['right'] * (len(_HEADS) - 1))
    return tabulate(rows, _HEADS, tablefmt=form, disable_numparse=True, colalign=align)


def _cells(one: Verdict) -> list[str]:
    return [
        'never' if one.parted is None else f'{one.parted:.1f}',
        f'{one.rms:.3f}',
        _UNKNOWN if one.delay is None else f'{one.delay:.1f}',
        _share(one.speed),
        _share(one.turn),
        f'{one.stopped:.1f}',
        _UNKNOWN if one.lost is None else str(one.lost),
    ]


def _share(one: Reached | None) -> str:
    return f'{one.had:.2f} of {one.asked:.2f}' if one else _UNKNOWN


def told(found: Mapping[int, Verdict]) -> Iterator[str]:
    """Yield the verdict on each robot in a sentence."""
    for robot, one in found.items():
        name = robot_name(robot)
        if one.parted is None:
            first = f'{name} stays with the simulation, {one.rms:.2g} m apart (RMS)'
        else:
            first = (
                f'{name} is more than {PART_M:g} m off the simulation from {one.parted:.1f} s on'
            )
        yield '; '.join([first, *_reasons(one)])


def _reasons(one: Verdict) -> Iterator[str]:
    if one.delay:
        when = 'later' if one.delay > 0 else 'earlier'
        yield f'it moves {abs(one.delay):.1f} s {when} in the experiment'
    if one.speed and one.speed.had < 0.95 * one.speed.asked:
        yield f'its top speed is {one.speed.had / one.speed.asked:.0%} of what was asked'
    if one.turn and one.turn.had < 0.9 * one.turn.asked:
        yield f'its top turn rate is {one.turn.had / one.turn.asked:.0%} of what was asked'
    if one.stopped >= 1.0:
        yield f'safety stopped it for {one.stopped:.1f} s'
    if one.lost:
        yield f'{one.lost} of its messages were lost'


def unknown(found: Mapping[int, Verdict]) -> Iterator[str]:
    """Yield what - stands for in the table, a line each."""
    if any(one.speed is None for one in found.values()):
        yield 'top speeds: the commands (cmd_vel) of the experiment were not recorded'
    if any(one.delay is None for one in found.values()):
        yield 'later by: speeds are not alike enough, or do not change'
    if any(one.lost is None for one in found.values()):
        yield 'messages lost: all robots knew all poses, no links were recorded'
