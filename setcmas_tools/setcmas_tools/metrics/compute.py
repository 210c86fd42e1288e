"""Metrics of a run from its fleet.csv: motion of the robots, and how well the task was done."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.control.saturation import VNOM
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.velocity_limits import MODELS
from setcmas_tools.metrics import task as task_metrics
from setcmas_tools.metrics.communication import CommunicationMetrics, communication_metrics
from setcmas_tools.metrics.consensus import ConsensusMetrics, consensus
from setcmas_tools.metrics.motion import RobotMotion, Separation, robot_motion, separation
from setcmas_tools.metrics.task import (
    DistanceMetrics,
    FormationMetrics,
    TrackingMetrics,
    WaypointMetrics,
)
from setcmas_tools.records import communication as communication_record
from setcmas_tools.records import fleet_table
from setcmas_tools.records.communication import CommunicationRecord
from setcmas_tools.records.fleet_grid import LONGEST_GAP_S, FleetGrid, on_grid
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.run.files import fleet_csv, run_parameters
from setcmas_tools.run.references import References, references, script_of_run, task_of


@dataclass(frozen=True)
class Metrics:
    """The metrics of a run; None for parts that do not apply to it.

    Attributes:
        task: What the robots were to do, one of `task_references.TASKS`, if that is known.
        duration_s: From the first to the last row at t >= 0.
        vnom_m_s: Largest speed that was asked of robots.
        communication: 'periodic' (each odometry is sent) or 'event-triggered'.
        robots: The motion of each robot.
        communications: How often each robot sent its state.
        messages: What went over the links, if the run has a record of it.
        separation: Distances of robots.
        consensus: Agreement on the position.
        formation: Errors of a formation by places.
        distances: Errors of a formation by distances.
        tracking: Errors to the reference trajectory.
        waypoints: Waypoints that were reached.
        mean_call_time_s: Mean time per call of each robot's control law. It differs between equal
            runs, so `metrics_yaml` leaves it out.
    """

    task: str | None
    duration_s: float
    vnom_m_s: float
    communication: str
    robots: dict[int, RobotMotion]
    communications: dict[int, int]
    separation: Separation | None
    consensus: ConsensusMetrics | None
    formation: FormationMetrics | None = None
    distances: DistanceMetrics | None = None
    tracking: TrackingMetrics | None = None
    waypoints: WaypointMetrics | None = None
    messages: CommunicationMetrics | None = None
    mean_call_time_s: dict[int, float] | None = None


def compute(
    run: Path,
    task: str | None = None,
    vnom: float | None = None,
    algo: str | None = None,
    call_times: Mapping[int, float] | None = None,
) -> Metrics:
    """Return the metrics of a run.

    Args:
        run: The folder of a run, the folder of its CSV files, or a fleet.csv.
        task: One of `task_references.TASKS`; by default that of the run's built-in law, if any.
        vnom: Largest speed in m/s; by default that of run.yaml, else VNOM.
        algo: Control law whose numbers count, as for `--algo`; by default that of run.yaml.
        call_times: Mean time per call of the control law by robot in s, if it was measured.

    Raises:
        SetcmasError: There is no fleet.csv, a file is damaged, or the control script does not
            define the numbers of the task.
    """
    source = fleet_csv(run)
    table = fleet_table.read_csv(source)
    if not (table.t >= 0).any():
        raise SetcmasError(f"'{source}' has no row at t >= 0: no robot was commanded")
    parameters = run_parameters(source)
    script = script_of_run(source, parameters, algo)
    task = task or task_of(script)
    settings = parameters.get('set') if algo is None else None
    goal = references(task, script, max(table.robots), settings) if task else None
    vnom = vnom if vnom is not None else _largest_speed(parameters)
    if not _is_number(vnom) or not 0 < vnom < math.inf:
        raise SetcmasError(f"vnom '{vnom}' is not a speed above 0 in m/s")
    record = communication_record.read_csv(source.parent)
    return measure(table, float(vnom), goal, record, call_times)


def _largest_speed(parameters: Mapping[str, Any]) -> Any:
    """Return the speed (m/s) that robots could reach: that asked for, or their own limit."""
    vnom = parameters.get('vnom', VNOM)
    limits = parameters.get('limits')
    if isinstance(limits, Mapping):  # those of a lab
        own = limits.get('V_max')
    else:
        own = MODELS[limits].V_max if limits in tuple(MODELS) else None
    return min(vnom, own) if _is_number(own) and _is_number(vnom) else vnom


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def measure(
    table: FleetTable,
    vnom: float = VNOM,
    goal: References | None = None,
    record: CommunicationRecord | None = None,
    call_times: Mapping[int, float] | None = None,
) -> Metrics:
    """Return the metrics of a fleet's motion.

    Args:
        table: The motion; rows at t >= 0 count, at least one.
        vnom: Largest speed that was asked of robots in m/s.
        goal: What the robots were to do.
        record: What went over the links, if that is known; without it each odometry counts as a
            state that was sent.
        call_times: Mean time per call of the control law by robot in s.
    """
    counted = table.rows(table.t >= 0)
    table = table.rows(np.isin(table.robot, counted.robots))
    grid = _grid_from_start(table)
    robots = counted.robots
    triggered = bool(record and record.is_event_triggered)
    sent = {robot: len(counted.of(robot).t) for robot in robots}
    if record:
        sent |= {robot: counts.sent for robot, counts in record.robots.items()}
    return Metrics(
        task=goal.task if goal else None,
        duration_s=float(counted.t[-1] - counted.t[0]),
        vnom_m_s=vnom,
        communication='event-triggered' if triggered else 'periodic',
        robots={robot: robot_motion(table.of(robot), vnom) for robot in robots},
        communications={robot: sent.get(robot, 0) for robot in robots},
        separation=separation(grid),
        consensus=consensus(grid),
        messages=communication_metrics(record) if record else None,
        mean_call_time_s=dict(call_times) if call_times else None,
        **(_task_metrics(goal, counted, grid) if goal else {}),
    )


def _task_metrics(goal: References, counted: FleetTable, grid: FleetGrid) -> dict[str, Any]:
    parts: dict[str, Any] = {}
    if goal.places is not None:
        parts['formation'] = task_metrics.formation(grid, goal.places)
    if goal.distance is not None:
        parts['distances'] = task_metrics.distances(grid, goal.distance)
    if goal.radius is not None and goal.rate is not None:
        parts['tracking'] = task_metrics.tracking(grid, goal.radius, goal.rate)
    if goal.waypoints is not None and goal.reached is not None:
        who = counted if goal.task == 'waypoints' else counted.of(task_metrics.LEADER)
        parts['waypoints'] = task_metrics.waypoints(who, goal.waypoints, goal.reached)
    return parts


def _grid_from_start(table: FleetTable) -> FleetGrid:
    grid = on_grid(table.rows(table.t >= -LONGEST_GAP_S))  # rows before 0 tell the poses at 0
    k = grid.t >= 0
    return FleetGrid(grid.t[k], grid.robots, grid.x[:, k], grid.y[:, k], grid.theta[:, k])
