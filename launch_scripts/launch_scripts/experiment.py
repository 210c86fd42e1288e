"""The processes of an experiment: started together, stopped in a safe order, and recorded."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from launch_scripts.environment import closed_environment, lab_environment
from launch_scripts.processes import (
    BRIDGES,
    CONTROLLER,
    EMULATED_LAB,
    JOYSTICK_READER,
    PAUSE,
    Child,
    node_command,
)
from launch_scripts.supervisor import StoppedError, Supervisor
from launch_scripts.terminal import ESC
from setcmas_ctrl.laws.control_options import ControllerOptions
from setcmas_expe.lab.lab import Lab
from setcmas_expe.lab.lab_file import LabOptions
from setcmas_expe.pause.console import Action, OperatorRequest, Status
from setcmas_simu.reports import ProcessMessage, Ready, Report, Started
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.run.scenario_lab import emulation_arguments

_STOPS = {
    ESC: (Action.EMERGENCY, 'by Esc'),
    'e': (Action.EMERGENCY, 'by e'),
    ' ': (Action.PAUSE, 'by space bar'),
}
"""If several arrive together, the first of these counts: stopping comes first."""

_TAKE_OVER_S = 0.5  # until the pause node stops the robots of a dead bridge


def experiment_environment(lab: Lab, emulated: bool) -> dict[str, str]:
    """Return the environment of an experiment; an emulated lab stays on this machine."""
    if emulated:
        return closed_environment()
    return lab_environment(lab.static_peers)


def start_emulated_lab(supervisor: Supervisor, arguments: Sequence[str]) -> Child:
    """Start an emulated lab; return it once it has made sure that it is the only one.

    Raises:
        ChildDiedError: The lab ended.
        StoppedError: The user stopped the command.
    """
    lab = supervisor.start('lab', node_command(EMULATED_LAB, arguments))
    supervisor.run(until=lambda: lab.reported(Ready) is not None)
    return lab


class Experiment:
    """Bridge, pause and controller processes, and optionally an emulated lab.

    Attributes:
        controllers: The process of the control laws; its calls are complete once it has ended.
        emulated: The process of the emulated lab, if there is one.
        runaways: Names of robots that moved although commanded zero.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        scenario: Scenario,
        lab_options: LabOptions,
        on_status: Callable[[Status], object],
        recorded: bool = False,
        hold: bool = False,
        watch: bool = False,
        joystick: list[str] | None = None,
    ) -> None:
        """Start the processes; `lab_options` give them the same lab.

        Until the robots are to stop, `on_status` is called several times a second with the state
        of the pause node and the robots. Controllers that are `recorded` wait for a recorder;
        with `hold`, robots move only while a key or a button is held; `joystick` is the command
        that reads one.

        Raises:
            ChildDiedError: The emulated lab ended.
            StoppedError: The user stopped the command meanwhile.
        """
        self._supervisor, self._on_status = supervisor, on_status
        self._stopped = False
        lab = lab_options.chosen()
        self.runaways: set[str] = set()
        self.emulated: list[Child] = []
        if scenario.lab.emulate:
            emulation = emulation_arguments(scenario, lab_options)
            self.emulated = [start_emulated_lab(supervisor, emulation)]
        of_lab = lab_options.arguments()
        self._bridges = supervisor.start('bridge', node_command(BRIDGES, of_lab))
        flags = ['--console', *['--hold'] * hold, *['--joystick'] * bool(joystick)]
        pause = node_command(PAUSE, [*of_lab, *flags])
        self._pause = supervisor.start(
            'pause', pause, listens=True, reports=Report | Status, on_report=self._on_report
        )
        if joystick:
            # Without it, whoever publishes on its topic would be the operator.
            supervisor.start('joystick', joystick)
        controllers = ControllerOptions(
            nb_robots=lab.nb_robots,
            experiment=True,
            pause_timeout=lab.timeouts.pause_s,
            recorded=recorded,
            limits=lab.limits,
            watch=watch,
        )
        in_lab = replace(scenario, safety=lab.safety(scenario.safety))
        laws = in_lab.law.arguments(in_lab.communication, in_lab.safety, controllers)
        self.controllers = supervisor.start('ctrl', node_command(CONTROLLER, laws))

    @property
    def controlled(self) -> bool:
        """Whether the control laws are running."""
        return self.controllers.reported(Started) is not None

    def request(self, action: Action, by: str = '') -> None:
        """Send an operator's request to the pause node; `by` is its source: 'by space bar'."""
        self._pause.send(OperatorRequest(action, by))

    def stop_by_keys(self, keys: str, attended: bool) -> None:
        """Pass on the keys that stop the robots; without them, that the terminal is attended.

        Raises:
            StoppedError: The operator pressed q.
        """
        if 'q' in keys:
            raise StoppedError
        if stop := next((_STOPS[key] for key in _STOPS if key in keys), None):
            self.request(*stop)
        elif attended:
            self.request(Action.ALIVE)

    def start_by_keys(self, starts: bool, releases: int) -> None:
        """Pass on the start key, and each press of the key that releases a stop."""
        for _ in range(releases):  # several: the key is held down
            self.request(Action.RELEASE)
        if starts:
            self.request(Action.START, 'by s')

    def stop(self) -> int:
        """Stop the robots, then all processes, once; return the exit status of the controllers."""
        if self._stopped:
            return self.controllers.exit_status
        self._stopped = True
        if self._bridges.running():
            self.request(Action.END)
            self._supervisor.stop(self._bridges)
        else:
            self.request(Action.HALT)
            self._supervisor.wait(_TAKE_OVER_S)
        self._supervisor.stop(self.controllers, self._pause)
        return self.controllers.exit_status

    def stop_lab(self) -> None:
        """Stop the emulated lab, after its recorder."""
        self._supervisor.stop(*self.emulated)

    def _on_report(self, report: ProcessMessage) -> None:
        if isinstance(report, Status):
            self.runaways |= {robot.name for robot in report.robots if robot.runs_away}
            if not self._stopped:  # later values are out of date
                self._on_status(report)


def joystick_command(topic: str) -> list[str] | None:
    """Return the command of ROS's joy_node, else of our reader; None without joy and pygame."""
    remap = ['--ros-args', '-r', f'joy:={topic}']
    for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        executable = Path(prefix) / 'lib' / 'joy' / 'joy_node'
        if prefix and executable.is_file():
            return [str(executable), *remap]
    if importlib.util.find_spec('pygame'):
        return node_command(JOYSTICK_READER, remap)
    return None
