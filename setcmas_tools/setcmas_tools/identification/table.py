"""Table of what a run tells of its robots, with what it does not tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tabulate import tabulate

from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.identification.identify import Channel, Identified

_HEADS = ('robot', 'speed', 'gain', 'lag (s)', 'delay (s)', 'fit (%)', 'measured with')
_UNKNOWN = '?'
_GOOD_FIT = 70.0


def table(found: Mapping[int, Identified]) -> str:
    """Return a row for each speed of each robot, with standard errors, ? for what is not told."""
    rows = [
        [robot_name(robot), name, *_cells(channel)]
        for robot, one in found.items()
        for name, channel in one.channels.items()
    ]
    align = ('left', 'left', *['right'] * 4, 'left')
    return tabulate(rows, _HEADS, tablefmt='simple', disable_numparse=True, colalign=align)


def _cells(channel: Channel) -> list[str]:
    fit, response, errors = channel.fit, channel.fit.response, channel.fit.errors
    gain = f'{response.gain:.3f} ± {errors.gain:.3f}' if fit.tells_gain else _UNKNOWN
    times = [(response.lag, errors.lag), (response.delay, errors.delay)]
    told = [f'{t:.3f} ± {e:.3f}' if fit.tells_times else _UNKNOWN for t, e in times]
    return [gain, *told, f'{max(0.0, fit.quality):.0f}', channel.told_by]


def notes(found: Mapping[int, Identified]) -> Iterator[str]:
    """Yield a line for each thing that the run does not tell, or tells badly."""
    for robot, one in found.items():
        name = robot_name(robot)
        if not one.channels:
            yield f'{name}: its motion was recorded for too short a time to tell anything'
        vague = [speed for speed, channel in one.channels.items() if not channel.fit.tells_times]
        if one.channels and one.responses is None:
            yield (
                f'{name}: its commands change too little to tell how it follows them, or it did '
                'not follow them; let it start, stop and turn more often'
            )
        elif vague:
            yield (
                f'{name}: its {" and ".join(vague)} changes too little to tell lag and delay; the '
                'model has those of its other speed, for the same wheels make both'
            )
        poor = [
            speed
            for speed, channel in one.channels.items()
            if channel.fit.tells_gain and channel.fit.quality < _GOOD_FIT
        ]
        if poor:
            yield (
                f'{name}: the model explains less than {_GOOD_FIT:g} % of its {" and ".join(poor)}'
                '; a pause, contact or slip may be why, and ± does not tell of these'
            )
