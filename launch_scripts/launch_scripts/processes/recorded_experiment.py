"""An emulated experiment that starts by itself and is recorded, and the lab of its scenario."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from launch_scripts.processes.experiment import Experiment
from launch_scripts.processes.run_processes import RecordedRun
from launch_scripts.processes.supervisor import Supervisor
from setcmas_ctrl.filter.barrier_constraints import check_starts
from setcmas_expe.emulation.emulation_options import (
    EmulationOptions,
    check_emulated_mocap,
    emulated_start_poses,
)
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import DEFAULT_FILE
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.pause.console import Action, Status
from setcmas_simu.robots.model import ROBOT_LIMITS
from setcmas_simu.robots.models import NO_LIMITS
from setcmas_tools.scenario.scenario import Scenario


def bounded_lab_options(
    scenario: Scenario, typed: Mapping[str, Any], from_file: bool, **others: Any
) -> LabOptions:
    """Return the options of a lab; a scenario file may tighten the others, never loosen them.

    Values that were `typed` override the lab file; scenarios do not have the `others`.

    Raises:
        SetcmasError: The scenario loosens something.
    """
    options = _lab_options(scenario, **others)
    if not from_file:
        return options
    which = {'algo': '', 'lab': scenario.lab.lab, 'nb_robots': scenario.robots.nb_robots}
    bounds = _lab_options(Scenario.of(**{**which, **typed}), **others).chosen()
    own = scenario.safety.obstacles
    if own and 'obstacles' not in typed:
        both = dict.fromkeys(filter(None, (str(bounds.obstacles), own)))
        options = replace(options, obstacles='; '.join(both))
    options.chosen().check_tightens(bounds)
    return options


def _lab_options(scenario: Scenario, **others: Any) -> LabOptions:
    """Return the lab's options for the processes; robots without limits have the lab's."""
    values = scenario.values()
    if values['limits'] == NO_LIMITS:
        values['limits'] = None
    return LabOptions.among({**values, **others})


def check_emulated(scenario: Scenario, lab: Lab) -> None:
    """Check that a lab can be emulated with the robots of a scenario.

    Raises:
        SetcmasError: It cannot, or robots would start too close to each other.
    """
    EmulationOptions.among(scenario.values()).robot_model([one.number for one in lab.robots])
    check_emulated_mocap(lab.mocap)
    poses = emulated_start_poses(lab.arena, lab.nb_robots, scenario.robots)
    check_starts(lab.safety(scenario.safety), poses)


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


_STOPPING_S = 2.0


class RecordedExperiment(RecordedRun):
    """Recorder, emulated lab, bridge, pause node and controllers; starts the robots itself.

    Attributes:
        started: Whether the robots are controlled and not paused.
        paused: Whether they are paused.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        scenario: Scenario,
        bag: Path,
        lab: Lab,
        lab_options: LabOptions,
        watch: bool,
        serve_keys: Callable[[Experiment], None],
    ) -> None:
        """Start the processes; `lab_options` give them the same lab.

        `serve_keys` is called several times a second, to pass on what the operator pressed.
        """
        self.started = False
        self.paused = True
        self._why_paused = ''
        self._changed = 0.0
        self._unready = ''
        self._serve_keys = serve_keys
        super().__init__(supervisor, bag)
        self._experiment = Experiment(
            supervisor, lab, scenario, lab_options, recorded=True, watch=watch
        )
        self._experiment.on_status = self._start_when_ready

    def _start_when_ready(self, status: Status) -> None:
        ready = all(robot.ready for robot in status.robots)
        if status.paused and self._experiment.controlled and ready and not self.started:
            self._experiment.request(Action.GO, 'by command')
        self.started = self.started or not status.paused
        if status.paused != self.paused:
            self.paused, self._changed = status.paused, time.monotonic()
        self._unready = '; '.join(
            f'{robot.name} is {robot.reason}' for robot in status.robots if not robot.ready
        )
        if self.started and status.paused and (status.emergency or not self._why_paused):
            self._why_paused = f'the robots were paused: {status.why}'

    @property
    def missing(self) -> str:
        """Why the run has not started yet."""
        if not self._experiment.controlled:
            return self._experiment.controllers.missing
        return self._unready or 'the bridge sends no status'

    @property
    def trouble(self) -> str:
        """Which robots did not stop, or why robots were paused; '' if all went well."""
        if runaways := ', '.join(sorted(self._experiment.runaways)):
            return f'{runaways} did not stop when commanded zero'
        return self._why_paused + '; nothing can start them again' * self.is_stuck

    @property
    def is_stuck(self) -> bool:
        """Whether robots stay paused for good: this command starts them only once."""
        at_rest = time.monotonic() - self._changed > _STOPPING_S
        return self.started and self.paused and at_rest

    def tick(self) -> None:
        """Serve the keys, which also shows the pause node that this command is running."""
        self._serve_keys(self._experiment)

    def finish(self) -> None:
        """Stop the robots and everything that commands them."""
        self.status = self._experiment.stop()
        self.failed = self._experiment.controllers.failed
        self.failures = self._experiment.controllers.failures

    def stop(self) -> None:
        """Stop all processes; the bag must contain the last command, zero."""
        self._experiment.stop()
        self._supervisor.stop(self.recorder)
        self._experiment.stop_lab()
