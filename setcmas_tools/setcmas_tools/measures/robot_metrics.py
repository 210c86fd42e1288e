"""Metrics of each robot: its motion, and its messages."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.laws.control_options import VNOM
from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import SLOW, Motion
from setcmas_simu.robots.models_by_name import fastest, motion_of
from setcmas_tools.measures.metric import Columns, Measured
from setcmas_tools.run.fleet_motion import LONGEST_GAP_S, FleetTable, resets
from setcmas_tools.run.run import Run, models_of
from setcmas_tools.run.run_records import agreement_time

SATURATION_TOLERANCE = 1e-3
"""A robot is saturated above (1 - this) vnom."""


_COLUMNS = {
    'path\n(m)': ('.2f', 'path_length_m'),
    'mean v\n(m/s)': ('.3f', 'mean_speed_m_s'),
    'max v\n(m/s)': ('.3f', 'largest_speed_m_s'),
    'saturated\n(s)': ('.1f', 'time_in_saturation_s'),
    'dead\nband (s)': ('.1f', 'time_in_dead_band_s'),
    'sent': ('.0f', 'communications'),
    'end x\n(m)': ('.2f', 'end_x_m'),
    'end y\n(m)': ('.2f', 'end_y_m'),
}


def fleet_motion(run: Run) -> Measured:
    """Return `robot_motion` of each robot of a run, by its number.

    Without a record of the communication, each odometry counts as a state sent.
    """
    robots = run.counted.robots
    sent = {robot: len(run.counted.of(robot).t) for robot in robots}
    if run.record:
        sent |= {robot: counts.sent for robot, counts in run.record.robots.items()}
    vnom = largest_speed(run)
    free = {robot for robot, one in models_of(run).items() if motion_of(one) is Motion.FREE}
    tracks = {robot: run.table.of(robot) for robot in robots}
    for robot in free & tracks.keys():
        tracks[robot] = replace(tracks[robot], v=_speeds(tracks[robot]))
    motions = {i: robot_motion(track, vnom, sent.get(i, 0)) for i, track in tracks.items()}
    columns = {
        head: (form, {robot: motion[name] for robot, motion in motions.items()})
        for head, (form, name) in _COLUMNS.items()
    }
    return Measured(motions, columns=columns)


def _speeds(track: FleetTable) -> Floats:
    """Return the speeds (m/s) between poses: v is forward only, and robots may drive sideways."""
    ways = np.hypot(np.diff(track.x), np.diff(track.y))
    times = np.diff(track.t)
    known = (times > 0.0) & ~resets(track)
    return np.append(np.nan, np.divide(ways, times, out=np.full(len(ways), np.nan), where=known))


def largest_speed(run: Run) -> float:
    """Return the speed (m/s) that the robots of a run can reach, at most that of its commands."""
    vnom = float(run.parameters.get('vnom', VNOM))
    limits = run.parameters.get('limits')
    if isinstance(limits, Mapping):  # those of a lab
        own = limits.get('V_max')
    else:
        model = run.parameters.get('model')
        files = (str(one.path) for one in run.inputs if one.option == 'model' and not one.robots)
        own = fastest(model and next(files, model), max(run.robots), str(limits))
    return vnom if own is None else min(vnom, float(own))


def robot_motion(track: FleetTable, vnom: float, communications: int) -> dict[str, float | None]:
    """Return the motion of a robot from its rows, at least one at t >= 0; None where unknown.

    The path length is the sum of the steps between poses, except resets; the mean speed is this
    length over the time from the first to the last pose. The largest speed, the saturation (at
    vnom, in m/s) and the dead band (below SLOW) use the odometry's speed |v|; a row counts for
    the time since the previous row, up to LONGEST_GAP_S. `communications` are the states sent.
    """
    counted = track.rows((track.t >= 0) & np.isfinite(track.x + track.y))
    driven = ~resets(counted)
    length = float(np.hypot(np.diff(counted.x), np.diff(counted.y))[driven].sum())
    duration = float(counted.t[-1] - counted.t[0]) if len(counted.t) else 0.0
    speeds = np.abs(track.v[(track.t >= 0) & np.isfinite(track.v)])
    return {
        'path_length_m': length,
        'mean_speed_m_s': length / duration if duration > 0 else None,
        'largest_speed_m_s': float(speeds.max()) if len(speeds) else None,
        'time_in_saturation_s': _time(track, np.abs(track.v) >= vnom * (1 - SATURATION_TOLERANCE)),
        'time_in_dead_band_s': _time(track, np.abs(track.v) < SLOW),
        'end_x_m': float(counted.x[-1]) if len(counted.t) else None,
        'end_y_m': float(counted.y[-1]) if len(counted.t) else None,
        'communications': communications,
    }


def _time(track: FleetTable, holds: NDArray[np.bool_]) -> float:
    """Return for how long (s) a condition on the rows of a robot held."""
    durations = np.diff(np.maximum(track.t, 0.0))
    known = np.diff(track.t) <= LONGEST_GAP_S
    return float(durations[holds[1:] & known].sum())


def fleet_communication(run: Run) -> Measured | None:
    """Return how much the robots of a run communicated; None without a record.

    A robot's messages are those that it sent. What was `received` and `lost`, over all links, is
    None if it was not counted, as in ROS 1; `agreement_time_s`, from which all laws send the same
    value, if they do not; evaluations of triggering conditions, the share that triggered and the
    shortest time between two states of a robot if communication was periodic, and times between
    states of robots that sent fewer than two.
    """
    record = run.record
    if not record:
        return None
    robots = record.robots
    sent = sum(counts.sent for counts in robots.values())
    received = sum(counts.received for counts in robots.values())
    lost = sum(counts.lost for counts in robots.values())
    evaluations = len(record.triggers) or None
    share = sent / evaluations if evaluations else None
    intervals = np.concatenate([np.empty(0), *record.intervals.values()])
    least = float(intervals.min()) if len(intervals) else None
    loss = lost / (received + lost) if received + lost else None
    counted = robots if record.links else {}
    arrived = {robot: counts.received for robot, counts in counted.items()}
    missing = {robot: counts.lost for robot, counts in counted.items()}
    every = {
        robot: counts.mean_interval if math.isfinite(counts.mean_interval) else None
        for robot, counts in robots.items()
    }
    columns: Columns = {
        'every\n(s)': ('.2f', every),
        'arrived': ('.0f', arrived),
        'lost': ('.0f', missing),
    }
    values = {
        'evaluations': evaluations,
        'triggered_share': share,
        'least_interval_s': least,
        'sent': sent,
        'received': received if record.links else None,
        'lost': lost if record.links else None,
        'loss_ratio': loss,
        'broken_links': int(np.sum(record.changes[:, 3] == 0.0)),
        'agreement_time_s': agreement_time(run.messages, len(run.robots)),
        'received_by_others': arrived,
        'lost_on_the_way': missing,
        'mean_interval_s': every,
    }
    line = f'communication: {sent:,} states sent'
    if evaluations and share is not None:
        line += f' ({100 * share:.1f} % of {evaluations:,} evaluations triggered)'
    if least is not None:
        line += f', those of a robot at least {least:.2f} s apart'
    if record.links:
        line += f', {received:,} messages received, {lost:,} lost'
        line += '' if loss is None else f' ({100 * loss:.1f} %)'
    return Measured(values, [line], columns)
