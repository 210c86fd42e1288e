"""Metrics of each robot: its motion, and its messages."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from setcmas_ctrl.laws.control_options import VNOM
from setcmas_simu.arrays import Floats
from setcmas_simu.robots.model import SLOW, Motion
from setcmas_simu.robots.models_by_name import fastest, motion_of
from setcmas_tools.measures.metric import Columns, Measured
from setcmas_tools.run.communication_record import agreement_time
from setcmas_tools.run.fleet_motion import LONGEST_GAP_S, FleetTable, resets
from setcmas_tools.run.run import Run, models_of

SATURATION_TOLERANCE = 1e-3
"""A robot is saturated above (1 - this) vnom."""


@dataclass(frozen=True)
class RobotMotion:
    """Motion of one robot from t = 0 on; None for unknown values."""

    path_length_m: float
    mean_speed_m_s: float | None
    largest_speed_m_s: float | None
    time_in_saturation_s: float
    time_in_dead_band_s: float
    end_x_m: float | None
    end_y_m: float | None
    communications: int


@dataclass(frozen=True)
class FleetMotion(Measured):
    """The motion of each robot, by its number."""

    robots: dict[int, RobotMotion]

    def __getitem__(self, robot: int) -> RobotMotion:
        return self.robots[robot]

    def columns(self) -> Columns:
        """Return the motion of each robot."""

        def values(name: str) -> dict[int, float | None]:
            return {robot: getattr(motion, name) for robot, motion in self.robots.items()}

        return {
            'path\n(m)': ('.2f', values('path_length_m')),
            'mean v\n(m/s)': ('.3f', values('mean_speed_m_s')),
            'max v\n(m/s)': ('.3f', values('largest_speed_m_s')),
            'saturated\n(s)': ('.1f', values('time_in_saturation_s')),
            'dead\nband (s)': ('.1f', values('time_in_dead_band_s')),
            'sent': ('.0f', values('communications')),
            'end x\n(m)': ('.2f', values('end_x_m')),
            'end y\n(m)': ('.2f', values('end_y_m')),
        }

    def as_dict(self) -> dict[Any, Any]:
        """Return the motion of each robot by its number."""
        return {robot: asdict(motion) for robot, motion in self.robots.items()}


def fleet_motion(run: Run) -> FleetMotion:
    """Return the motion of each robot of a run.

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
    return FleetMotion(
        {robot: robot_motion(track, vnom, sent.get(robot, 0)) for robot, track in tracks.items()}
    )


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


def robot_motion(track: FleetTable, vnom: float, communications: int) -> RobotMotion:
    """Return the motion of a robot from its rows, at least one of them at t >= 0.

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
    return RobotMotion(
        path_length_m=length,
        mean_speed_m_s=length / duration if duration > 0 else None,
        largest_speed_m_s=float(speeds.max()) if len(speeds) else None,
        time_in_saturation_s=_time(track, np.abs(track.v) >= vnom * (1 - SATURATION_TOLERANCE)),
        time_in_dead_band_s=_time(track, np.abs(track.v) < SLOW),
        end_x_m=float(counted.x[-1]) if len(counted.t) else None,
        end_y_m=float(counted.y[-1]) if len(counted.t) else None,
        communications=communications,
    )


def _time(track: FleetTable, holds: NDArray[np.bool_]) -> float:
    """Return for how long (s) a condition on the rows of a robot held."""
    durations = np.diff(np.maximum(track.t, 0.0))
    known = np.diff(track.t) <= LONGEST_GAP_S
    return float(durations[holds[1:] & known].sum())


@dataclass(frozen=True)
class CommunicationMetrics(Measured):
    """Messages of a run; those of a robot are the ones it sent.

    Attributes:
        evaluations: Evaluations of triggering conditions; None if communication was periodic.
        triggered_share: Share of the evaluations that triggered; None if it was periodic.
        least_interval_s: Shortest time between two states of a robot; None if it was periodic, or
            if no robot sent two.
        sent: States that robots broadcast.
        received: Messages that arrived, over all links; None if not counted, as in ROS 1.
        lost: Messages that were lost, over all links; None likewise.
        loss_ratio: lost / (received + lost); None without messages.
        broken_links: Number of times that a link ended.
        agreement_time_s: Time from which all laws send the same value; None if they do not.
        received_by_others: Messages of each robot that arrived; empty if not counted.
        lost_on_the_way: Messages of each robot that were lost; empty if not counted.
        mean_interval_s: Mean time between broadcasts of each robot; None for fewer than two.
    """

    evaluations: int | None
    triggered_share: float | None
    least_interval_s: float | None
    sent: int
    received: int | None
    lost: int | None
    loss_ratio: float | None
    broken_links: int
    agreement_time_s: float | None
    received_by_others: dict[int, int]
    lost_on_the_way: dict[int, int]
    mean_interval_s: dict[int, float | None]

    def columns(self) -> Columns:
        """Return the messages of each robot."""
        return {
            'every\n(s)': ('.2f', self.mean_interval_s),
            'arrived': ('.0f', self.received_by_others),
            'lost': ('.0f', self.lost_on_the_way),
        }

    def lines(self) -> list[str]:
        """Return the messages of the fleet."""
        sent = f'{self.sent:,} states sent'
        if self.evaluations and self.triggered_share is not None:
            share = f'{100 * self.triggered_share:.1f} % of {self.evaluations:,} evaluations'
            sent += f' ({share} triggered)'
        if self.least_interval_s is not None:
            sent += f', those of a robot at least {self.least_interval_s:.2f} s apart'
        if self.received is None:
            return [f'communication: {sent}']
        loss = '' if self.loss_ratio is None else f' ({100 * self.loss_ratio:.1f} %)'
        return [
            f'communication: {sent}, {self.received:,} messages received, {self.lost:,} lost{loss}'
        ]


def fleet_communication(run: Run) -> CommunicationMetrics | None:
    """Return how much the robots of a run communicated; None without a record."""
    record = run.record
    if not record:
        return None
    robots = record.robots
    sent = sum(counts.sent for counts in robots.values())
    received = sum(counts.received for counts in robots.values())
    lost = sum(counts.lost for counts in robots.values())
    evaluations = len(record.triggers) or None
    intervals = np.concatenate([np.empty(0), *record.intervals.values()])
    return CommunicationMetrics(
        evaluations=evaluations,
        triggered_share=sent / evaluations if evaluations else None,
        least_interval_s=float(intervals.min()) if len(intervals) else None,
        sent=sent,
        received=received if record.links else None,
        lost=lost if record.links else None,
        loss_ratio=lost / (received + lost) if received + lost else None,
        broken_links=int(np.sum(record.changes[:, 3] == 0.0)),
        agreement_time_s=agreement_time(run.messages, len(run.robots)),
        received_by_others={i: counts.received for i, counts in robots.items() if record.links},
        lost_on_the_way={i: counts.lost for i, counts in robots.items() if record.links},
        mean_interval_s={
            robot: counts.mean_interval if math.isfinite(counts.mean_interval) else None
            for robot, counts in robots.items()
        },
    )
