"""Text of the panel beside the scene, in HTML: the fleet's figures and a row per robot."""

from __future__ import annotations

import html
import math
from dataclasses import dataclass

from setcmas_simu.fleet import fleet
from setcmas_tools.view.model.robot_states import ERROR, OK, WARN

_STATE_COLOURS = {OK: 'inherit', WARN: '#b45309', ERROR: '#b91c1c'}
_STYLE = (
    '<style>.sc{font-size:12.5px;line-height:1.5;padding:2px 12px 8px}'
    '.sc .f{display:flex;justify-content:space-between;font-size:15px}'
    '.sc table{width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums}'
    # As many robots as leave room for what is above and below them.
    '.sc .r{max-height:max(7em,calc(100vh - 395px));overflow-y:auto;margin-top:6px}'
    '.sc th{font-weight:500;opacity:.6;text-align:right;position:sticky;top:0}'
    '.sc td{text-align:right;white-space:nowrap;padding:0 0 0 7px}'
    '.sc th:last-child,.sc td:last-child{text-align:left;white-space:normal}'
    '.sc th:first-child,.sc td:first-child{text-align:left;padding:0}'
    '.sc i{display:inline-block;width:9px;height:9px;border-radius:50%;'
    'border:1px solid #8888;margin-right:5px}</style>'
)
_RUN_TIME = '<span title="since the first command that this page has heard">run time</span>'


@dataclass(frozen=True)
class RobotRow:
    """What the panel tells of a robot: speed in m/s, pose in m and rad, level, state, if lost."""

    robot: int
    speed: float
    pose: tuple[float, float, float]
    level: int
    state: str
    lost: bool = False


def panel_html(
    rows: list[RobotRow], run: str, time_s: float | None, disagreement: float | None
) -> str:
    """Return the panel's text.

    Args:
        rows: One for each robot.
        run: What the fleet does, in words.
        time_s: Time of the run in s; None before it.
        disagreement: Root mean square distance to the fleet's centre in m; None below two robots.
    """
    if not rows:
        return f'{_STYLE}<div class="sc">waiting for robots</div>'
    figures = [(_count(rows), run)]
    if time_s is not None:
        figures.append((_RUN_TIME, f'{time_s:.1f} s'))
    if disagreement is not None:
        figures.append(('disagreement', f'{disagreement:.3f} m'))
    lines = ''.join(f'<div class="f"><span>{a}</span><b>{b}</b></div>' for a, b in figures)
    head = (
        '<tr><th></th><th>m/s</th><th>x (m)</th><th>y (m)</th><th>θ (°)</th><th>&nbsp;</th></tr>'
    )
    body = ''.join(map(_row_html, rows))
    return f'{_STYLE}<div class="sc">{lines}<div class="r"><table>{head}{body}</table></div></div>'


def _count(rows: list[RobotRow]) -> str:
    lost = sum(row.lost for row in rows)
    there = len(rows) - lost
    count = f'{there} robot' + ('' if there == 1 else 's')
    return f'{count}, {lost} lost' if lost else count


def _row_html(row: RobotRow) -> str:
    red, green, blue = (round(255 * part) for part in fleet.plot_colour(row.robot))
    x, y, theta = row.pose
    cells = [_number(value, 2) for value in (row.speed, x, y)]
    cells.append(_number(math.degrees(theta), 0))
    state = html.escape(row.state)
    return (
        f'<tr><td><i style="background:rgb({red},{green},{blue})"></i>{row.robot}</td>'
        + ''.join(f'<td>{cell}</td>' for cell in cells)
        + f'<td style="color:{_STATE_COLOURS[row.level]}">{state}</td></tr>'
    )


def _number(value: float, digits: int) -> str:
    """Return a number without a minus before what is rounded to 0."""
    return f'{round(value, digits) + 0.0:.{digits}f}'.replace('-', '−')
