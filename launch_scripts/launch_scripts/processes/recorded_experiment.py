"""An emulated experiment that starts by itself and is recorded."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from launch_scripts.processes.experiment import Experiment
from launch_scripts.processes.run_processes import RecordedRun
from launch_scripts.processes.supervisor import Supervisor
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.pause.console import Action, Status
from setcmas_tools.scenario.scenario import Scenario

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
        """Start the processes.

        Args:
            supervisor: Starts them.
            scenario: The experiment, with the values of its lab.
            bag: Folder of the bag.
            lab: The lab.
            lab_options: Options that give the processes the same lab.
            watch: Whether scripts are reloaded on every save.
            serve_keys: Passes on what the operator pressed; called several times a second.
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
            return self._experiment.missing
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
        self.failed = self._experiment.failed
        self.failures = self._experiment.failures

    def stop(self) -> None:
        """Stop all processes; the bag must contain the last command, zero."""
        self._experiment.stop()
        self._supervisor.stop(self.recorder)
        self._experiment.stop_lab()
