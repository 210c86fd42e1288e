"""The processes of `setcmas run --emulate`: an experiment in an emulated lab, and a recorder."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

from launch_scripts.processes.experiment import Experiment
from launch_scripts.processes.run_processes import RecordedRun
from launch_scripts.processes.supervision.child_process import Child
from launch_scripts.processes.supervision.supervisor import Supervisor
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_options import LabOptions
from setcmas_expe.pause.console_protocol import Status, Word
from setcmas_simu.robots.velocity_limits import ROBOT_MODELS

_COMES_TO_REST_S = 2.0


def emulated_lab_options(args: argparse.Namespace) -> LabOptions:
    """Return the lab of an emulated run: its file, and the options that override it."""
    limits = args.limits if args.limits in ROBOT_MODELS else None  # by default there are none
    return LabOptions.of(argparse.Namespace(**{**vars(args), 'limits': limits}))


class EmulatedRun(RecordedRun):
    """Recorder, emulated lab, bridge, pause node and controllers; it presses start itself.

    Attributes:
        started: Whether the robots are under control and not paused.
        paused: Whether they are paused now.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        args: argparse.Namespace,
        bag: Path,
        lab: Lab,
        pages: Sequence[Child] = (),
    ) -> None:
        """Start the processes; robots that somebody has paused can be started on the pages."""
        self.started = False
        self.paused = True
        self._paused = ''
        self._changed = 0.0
        self._pages = pages
        self._unready = ''
        super().__init__(supervisor, bag)
        told = emulated_lab_options(args)
        self._experiment = Experiment(supervisor, lab, args, told, recorded=True)
        self._experiment.on_status = self._start_when_ready
        self._experiment.on_script = self.reloads.take
        for page in pages:
            self._experiment.follow_page(page)

    def _start_when_ready(self, status: Status) -> None:
        ready = all(robot.ready for robot in status.robots)
        if status.paused and self._experiment.controlled and ready and not self.started:
            self._experiment.wish(Word.GO, 'by command')
        self.started = self.started or not status.paused
        if status.paused != self.paused:
            self.paused, self._changed = status.paused, time.monotonic()
        self._unready = '; '.join(
            f'{robot.name} is {robot.reason}' for robot in status.robots if not robot.ready
        )
        if self.started and status.paused and (status.emergency or not self._paused):
            self._paused = f'the robots were paused: {status.why}'

    @property
    def missing(self) -> str:
        """What a run that has not started waits for."""
        if not self._experiment.controlled:
            return self._experiment.missing
        return self._unready or 'nothing is heard of the bridge process'

    @property
    def trouble(self) -> str:
        """Why the robots were paused meanwhile, or which did not stop; empty if all went well."""
        if runaways := ', '.join(sorted(self._experiment.runaways)):
            return f'{runaways} did not stop when commanded zero'
        return self._paused + '; nobody is here to start them again' * self.is_stuck

    @property
    def is_stuck(self) -> bool:
        """Whether robots stay paused, at rest by now: no page is there to start them."""
        at_rest = time.monotonic() - self._changed > _COMES_TO_REST_S
        waits = any(page.running() for page in self._pages)
        return self.started and self.paused and at_rest and not waits

    def tick(self) -> None:
        """Show the pause process that somebody is there; ten times a second."""
        self._experiment.wish(Word.ALIVE)

    def finish(self) -> None:
        """Stop the robots and all that commands them."""
        self.status = self._experiment.stop()
        self.failed = self._experiment.failed
        self.failures = self._experiment.failures

    def stop(self) -> None:
        """Stop all; the last command, zero, is to be in the bag."""
        self._experiment.stop()
        self._supervisor.stop(self.recorder)
        self._experiment.stop_lab()
