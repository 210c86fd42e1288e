"""The table of a run's metrics for the terminal."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from tabulate import tabulate

from setcmas_simu.fleet.topics import robot_name
from setcmas_tools.metrics.communication import CommunicationMetrics
from setcmas_tools.metrics.compute import Metrics

MOST_ROBOTS_IN_ROWS = 50
"""Of larger fleets the table shows the least, the mean and the largest values."""

_MOST_ROBOTS_WITH_TIMES = 8

Column = Mapping[int, float | None]


def table_lines(metrics: Metrics) -> list[str]:
    """Return metrics as lines of text: a row for each robot, then what concerns the fleet."""
    return [*_robot_lines(metrics), *_fleet_lines(metrics), *_task_lines(metrics)]


def _columns(metrics: Metrics) -> dict[str, tuple[str, Column]]:
    """Return the values of each column by robot, with their format, by header."""

    def motion(name: str) -> Column:
        return {robot: getattr(values, name) for robot, values in metrics.robots.items()}

    columns: dict[str, tuple[str, Column]] = {
        'path\n(m)': ('.2f', motion('path_length_m')),
        'mean v\n(m/s)': ('.3f', motion('mean_speed_m_s')),
        'max v\n(m/s)': ('.3f', motion('largest_speed_m_s')),
        'at max\n(s)': ('.1f', motion('time_in_saturation_s')),
        'sent': ('.0f', metrics.communications),
        **_message_columns(metrics),
        'end x\n(m)': ('.2f', motion('end_x_m')),
        'end y\n(m)': ('.2f', motion('end_y_m')),
    }
    if metrics.formation:
        errors = metrics.formation
        columns['error at\nend (m)'] = ('.3f', errors.position_error_final_m)
        columns['RMS last\n25 % (m)'] = ('.3f', errors.position_error_rms_last_quarter_m)
    if metrics.tracking:
        columns['RMS error\n(m)'] = ('.3f', metrics.tracking.tracking_error_rms_m)
        late = metrics.tracking.tracking_error_rms_second_half_m
        columns['RMS 2nd\nhalf (m)'] = ('.3f', late)
    if metrics.waypoints:
        reached = metrics.waypoints.reached_at_s
        columns['way-\npoints'] = ('.0f', {i: len(times) for i, times in reached.items()})
    if metrics.mean_call_time_s:
        milliseconds = {i: time * 1e3 for i, time in metrics.mean_call_time_s.items()}
        columns['call\n(ms)'] = ('.3f', milliseconds)
    return columns


def _message_columns(metrics: Metrics) -> dict[str, tuple[str, Column]]:
    if not metrics.messages:
        return {}
    return {
        'every\n(s)': ('.2f', metrics.messages.mean_interval_s),
        'arrived': ('.0f', metrics.messages.received_by_others),
        'lost': ('.0f', metrics.messages.lost_on_the_way),
    }


def _robot_lines(metrics: Metrics) -> list[str]:
    columns = _columns(metrics)
    if len(metrics.robots) <= MOST_ROBOTS_IN_ROWS:
        rows = [
            [
                robot_name(robot),
                *(_text(values.get(robot), form) for form, values in columns.values()),
            ]
            for robot in metrics.robots
        ]
    else:
        summaries: dict[str, Callable[[list[float]], float]] = {
            'least': min,
            'mean': lambda values: float(np.mean(values)),
            'largest': max,
        }
        rows = [
            [name, *(_text(_summary(values, of), form) for form, values in columns.values())]
            for name, of in summaries.items()
        ]
    headers = [f'{len(metrics.robots)}\nrobots' if len(rows) != len(metrics.robots) else 'robot']
    text = tabulate(
        rows,
        [*headers, *columns],
        tablefmt='simple',
        disable_numparse=True,
        colalign=('left', *['right'] * len(columns)),
    )
    return text.splitlines()


def _summary(values: Column, of: Callable[[list[float]], float]) -> float | None:
    known = [value for value in values.values() if value is not None]
    return of(known) if known else None


def _text(value: float | None, form: str = '.2f') -> str:
    text = '-' if value is None else format(value, form)
    return text.lstrip('-') if text.startswith('-0') and not float(text) else text


def _fleet_lines(metrics: Metrics) -> list[str]:
    lines = []
    if near := metrics.separation:
        first, second = near.least_separation_robots
        lines += [
            f'least separation: {near.least_separation_m:.2f} m at '
            f'{near.least_separation_time_s:.1f} s between robots {first} and {second}',
            'largest distance between two robots at the end: '
            f'{_text(near.largest_distance_at_end_m)} m',
        ]
    # Robots with another task need not meet.
    if (agreement := metrics.consensus) and metrics.task in (None, 'consensus'):
        lines += [
            f'disagreement: {agreement.disagreement_at_start_m:.3f} m at the start, '
            f'{agreement.disagreement_at_end_m:.3f} m at the end',
            f'disagreement below 5 % {_when(agreement.settling_time_5_percent_s)}, '
            f'below 2 % {_when(agreement.settling_time_2_percent_s)}',
            f'centre at the end: ({agreement.final_centre_x_m:.2f}, '
            f'{agreement.final_centre_y_m:.2f}) m',
        ]
    if messages := metrics.messages:
        lines.append(_messages_line(messages))
    return lines


def _messages_line(messages: CommunicationMetrics) -> str:
    sent = f'{messages.sent:,} states sent'
    if messages.evaluations and messages.triggered_share is not None:
        share = f'{100 * messages.triggered_share:.1f} % of {messages.evaluations:,} evaluations'
        sent += f' ({share} triggered)'
    if messages.received is None:
        return f'communication: {sent}'
    loss = '' if messages.loss_ratio is None else f' ({100 * messages.loss_ratio:.1f} %)'
    return (
        f'communication: {sent}, {messages.received:,} messages received, '
        f'{messages.lost:,} lost{loss}'
    )


def _when(time: float | None) -> str:
    return 'not reached' if time is None else f'from {time:.1f} s on'


def _task_lines(metrics: Metrics) -> list[str]:
    lines = []
    if formation := metrics.formation:
        rms = formation.fleet_position_error_rms_last_quarter_m
        lines.append(f'formation: RMS error of the places over the last 25 %: {rms:.3f} m')
    if errors := metrics.distances:
        lines.append(
            f'distances: RMS error {errors.distance_error_final_rms_m:.3f} m at the end '
            f'(largest {errors.distance_error_final_largest_m:.3f} m), '
            f'{errors.distance_error_rms_last_quarter_m:.3f} m over the last 25 %'
        )
    if tracking := metrics.tracking:
        lines.append(
            f'tracking: RMS error {tracking.fleet_tracking_error_rms_m:.3f} m, '
            f'{tracking.fleet_tracking_error_rms_second_half_m:.3f} m over the second half'
        )
    if waypoints := metrics.waypoints:
        number = len(waypoints.waypoints_m)
        for robot, times in list(waypoints.reached_at_s.items())[:_MOST_ROBOTS_WITH_TIMES]:
            visits = ', '.join(f'{k % number + 1} at {time:.1f}' for k, time in enumerate(times))
            lines.append(f'waypoints of {robot_name(robot)}: {visits + " s" if times else "none"}')
    return lines
