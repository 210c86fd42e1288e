"""The lab of a scenario: what it may tighten of a lab file, and the values of an emulated one."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping
from dataclasses import astuple, replace
from typing import Any

from setcmas_ctrl.filter.barrier_constraints import check_starts
from setcmas_ctrl.filter.filter_options import NONE
from setcmas_expe.emulation.emulation_options import (
    EmulationOptions,
    check_emulated_mocap,
    emulated_start_poses,
)
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import DEFAULT_FILE, LabOptions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.model import ROBOT_LIMITS
from setcmas_simu.robots.models_by_name import NO_LIMITS
from setcmas_tools.run.scenario import Scenario


def bounded_lab_options(
    scenario: Scenario, typed: Mapping[str, Any], from_file: bool
) -> LabOptions:
    """Return the options of a lab; a scenario file may tighten the lab's, never loosen them.

    Values that were `typed` override the lab file.

    Raises:
        SetcmasError: The scenario loosens something.
    """
    options = _lab_options(scenario)
    if not from_file:
        return options
    which = {'lab': scenario.lab.lab, 'nb_robots': scenario.robots.nb_robots}
    bounds = _lab_options(Scenario.of('', **{**which, **typed})).chosen()
    own = scenario.safety.obstacles
    if own and 'obstacles' not in typed:
        both = dict.fromkeys(filter(None, (str(bounds.obstacles), own)))
        options = replace(options, obstacles='; '.join(both))
    check_tightens(options.chosen(), bounds)
    return options


def check_tightens(lab: Lab, bounds: Lab) -> None:
    """Check that a lab allows nothing that another lab forbids.

    Raises:
        SetcmasError: It does; the message names it.
    """
    (xmin, xmax, ymin, ymax), outer = lab.arena, bounds.arena
    inside = outer.distance(xmin, ymin) == outer.distance(xmax, ymax) == 0
    own, most = astuple(lab.limits), astuple(bounds.limits)
    slower = all(map(operator.le, own[:3], most[:3]))
    checks = {
        'arena': (inside, f'inside {", ".join(f"{border:g}" for border in outer)} m'),
        'min_separation': (
            lab.min_separation >= bounds.min_separation,
            f'at least {bounds.min_separation:g} m',
        ),
        'filter': (lab.filter == bounds.filter or bounds.filter == NONE, bounds.filter),
        'limits': (slower, f'at most {bounds.limits.V_max:g} m/s, and no faster in turns'),
        'accel': (lab.accel <= bounds.accel, f'at most {bounds.accel:g} m/s^2'),
        'lidar_stop': (lab.lidar_stop or not bounds.lidar_stop, 'true'),
        'without_guard': (lab.guarded or not bounds.guarded, 'false'),
        'without_motion_check': (lab.checks_motion or not bounds.checks_motion, 'false'),
    }
    for name, (tightens, accepted) in checks.items():
        if not tightens:
            raise SetcmasError(
                f'{name} of the scenario loosens what the lab file sets; it must be {accepted}'
            )


def _lab_options(scenario: Scenario) -> LabOptions:
    """Return the lab's options for the processes; robots without limits have the lab's."""
    values = scenario.values()
    if values['limits'] == NO_LIMITS:
        values['limits'] = None
    return LabOptions.among(values)


def check_emulated(scenario: Scenario, lab: Lab) -> None:
    """Check that a lab can be emulated with the robots of a scenario.

    Raises:
        SetcmasError: It cannot, or robots would start too close to each other.
    """
    EmulationOptions.among(scenario.values()).robot_model([one.number for one in lab.robots])
    check_emulated_mocap(lab.mocap)
    poses = emulated_start_poses(lab.arena, lab.nb_robots, scenario.robots)
    check_starts(lab.safety(scenario.safety), poses)


def emulation_arguments(scenario: Scenario, lab_options: LabOptions) -> list[str]:
    """Return the arguments of a process that emulates a lab with the robots of a scenario."""
    return lab_options.arguments(EmulationOptions.among(scenario.values()))


def in_lab(scenario: Scenario, lab: Lab) -> Scenario:
    """Return a scenario with the values of its emulated lab."""
    known = (name for name, limits in ROBOT_LIMITS.items() if limits == lab.limits)
    return scenario.replace(
        lab=scenario.lab.lab or DEFAULT_FILE,
        nb_robots=lab.nb_robots,
        poses=emulated_start_poses(lab.arena, lab.nb_robots, scenario.robots),
        pose=(),
        random_poses=None,
        limits=NO_LIMITS if scenario.robots.model else next(known, NO_LIMITS),
        filter=lab.filter,
        arena=lab.arena,
        min_separation=lab.min_separation,
        obstacles=str(lab.obstacles) or None,
        accel=lab.accel if lab.accel < math.inf else None,
    )
