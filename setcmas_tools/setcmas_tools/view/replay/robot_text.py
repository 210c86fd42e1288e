"""One robot at an instant, in HTML."""

from __future__ import annotations

import html
import math

import numpy as np

from setcmas_ctrl.filter.barrier import Verdict
from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.replay.instant import RobotInstant, Velocity

_NOT_RECORDED = 'not recorded'
_VERDICTS = {
    Verdict.KEPT: 'let through',
    Verdict.CHANGED: 'changed',
    Verdict.BLOCKED: 'changed; the robot is blocked',
    Verdict.NO_SOLUTION: 'no solution: the robot stands',
}
_MOST_KNOWN = 60
_STYLE = (
    '<style>.sr{font-size:12.5px;line-height:1.45;padding:2px 12px}.sr table{width:100%}'
    '.sr td:first-child{opacity:.6;padding-right:8px;white-space:nowrap}'
    '.sr td{font-variant-numeric:tabular-nums;vertical-align:top}.sr .k td{text-align:right}'
    '.sr pre{color:#b91c1c;white-space:pre-wrap;margin:4px 0}</style>'
)


def robot_html(one: RobotInstant, true_poses: Floats) -> str:
    """Return what is known of a robot.

    Args:
        one: The robot.
        true_poses: Those of all robots at the call of its law, by robots' numbers from 1.
    """
    x, y, theta = one.pose
    rows = [
        ('pose', f'{_number(x)} m, {_number(y)} m, {_number(math.degrees(theta), 2)}°'),
        ('speed', f'{_number(one.speed)} m/s, {_number(one.turn_rate)} rad/s'),
        ('law called', _NOT_RECORDED if one.called_at is None else f't = {one.called_at:.2f} s'),
        ('wanted', _wanted(one)),
    ]
    if one.verdict is not None:
        rows.append(('filter', f'{_velocity(one.allowed)} ({_VERDICTS[one.verdict]})'))
    if one.state is not None:
        over = '; overruled' if one.overruled else ''
        rows.append(('let do', html.escape(one.state) + over))
    table = ''.join(f'<tr><td>{name}</td><td>{text}</td></tr>' for name, text in rows)
    failure = ''
    if one.failure:
        failure = f'<pre>{html.escape(one.failure.text)}</pre>'
    return (
        f'{_STYLE}<div class="sr"><b>{robot_name(one.robot)}</b>'
        f'<table>{table}</table>{failure}{_known(one, true_poses)}</div>'
    )


def _wanted(one: RobotInstant) -> str:
    if one.failure:
        return 'nothing: control failed'
    return _velocity(one.wanted) + (' (the largest speed)' if one.saturated else '')


def _velocity(velocity: Velocity | None) -> str:
    if velocity is None:
        return _NOT_RECORDED
    return f'({_number(velocity[0])}, {_number(velocity[1])}) m/s'


def _known(one: RobotInstant, true_poses: Floats) -> str:
    """Return the table of what it knew of the others, and by how much that was off."""
    if one.known is None:
        return f'<div>what it knew: {html.escape(one.unknown)}</div>'
    rows = ''
    for number in range(1, min(one.known.shape[1], _MOST_KNOWN) + 1):
        if number == one.robot:
            continue
        x, y, theta = one.known[:, number - 1]
        if not np.isfinite(x):
            rows += f'<tr><td>{number}</td><td colspan=4>not heard</td></tr>'
            continue
        cells = [_number(float(v), 2) for v in (x, y, np.degrees(theta))]
        off = np.hypot(*(one.known[:2, number - 1] - true_poses[:2, number - 1]))
        cells.append(_number(float(off), 2) if np.isfinite(off) else '–')
        rows += f'<tr><td>{number}</td>' + ''.join(f'<td>{cell}</td>' for cell in cells) + '</tr>'
    head = '<tr><td></td><td>x (m)</td><td>y (m)</td><td>θ (°)</td><td>off (m)</td></tr>'
    return f'<div>it knew of the others</div><table class="k">{head}{rows}</table>'


def _number(value: float, digits: int = 3) -> str:
    if not math.isfinite(value):
        return '–'
    return f'{round(value, digits) + 0.0:.{digits}f}'.replace('-', '−')
