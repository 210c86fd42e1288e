"""The scripts of a process of controllers: laws, triggering conditions and conversions."""

from __future__ import annotations

from functools import partial
from operator import attrgetter
from pathlib import Path

import rclpy
from std_msgs.msg import String

from setcmas_ctrl.communication.communication_options import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.triggering_conditions import CONSEQUENCE, CTC, Broadcast
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.control_options import LawOptions
from setcmas_ctrl.laws.references import references_of_fleet
from setcmas_ctrl.laws.script_errors import STOPPED, ErrorReports
from setcmas_ctrl.laws.script_search import LawScripts
from setcmas_ctrl.laws.script_seeds import seed_scripts
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.reports import Ended, Failed
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.script_calls import Function, ScriptCall

_CONSEQUENCES = {
    Function.CONTROL: STOPPED,
    Function.CONDITION: CONSEQUENCE,
    Function.SI_TO_UNI: STOPPED,
}
"""What happens to a robot when a function of its scripts fails."""


class FleetScripts:
    """Loads the scripts of a process's robots, each time with fresh state.

    Attributes:
        robots: Numbers of the robots.
        nb_robots: Size of the fleet.
        watch: Times the calls of scripts.
        communication: How the robots communicate.
        laws: The control laws; none where other programs publish the velocities.
        reports: Where errors of each function go.
        condition: The script of a triggering condition, if it is one.
        conversion: The user's own si_to_uni, if there is one.
    """

    def __init__(
        self,
        process: RosProcess,
        node: FleetNode,
        law: LawOptions,
        scripts: LawScripts | None,
        communication: CommunicationOptions,
        robots: list[int],
        nb_robots: int,
    ) -> None:
        """Load the laws of robots of a fleet; the node shows their task, and warnings.

        There are no `scripts` where other programs publish the velocities.

        Raises:
            SetcmasError: A script does not load.
        """
        self.robots, self.nb_robots, self._seed = robots, nb_robots, law.seed
        self.communication = chosen_communication(nb_robots, communication, law.seed)
        self.condition = self.communication.condition_script
        self.conversion = law.conversion()
        self._warn, self._launcher = node.get_logger().warning, process.launcher
        self.watch = CallWatch(self._warn, self._launcher)
        process.on_stop_signal = self.watch.stop_call
        self._task = node.create_publisher(String, topics.TASK, qos.LATCHED)
        self._scripts = scripts
        self._failed: list[ScriptCall] = []
        self.reports = self._first_reports = self._new_reports()
        self.laws: list[ControlLaw] = []
        if scripts:
            scripts.check(nb_robots)
            self.laws = self._loaded(scripts)

    def _new_reports(self) -> dict[Function, ErrorReports]:
        """Return where errors go, of scripts that have just been loaded."""
        return {
            function: ErrorReports(
                self._warn, consequence, partial(self._note, function), function
            )
            for function, consequence in _CONSEQUENCES.items()
        }

    def _note(self, function: Function, robot: int, text: str) -> None:
        """Note that a call has failed, for the launcher and the exit status."""
        script = {Function.CONDITION: self.condition, Function.SI_TO_UNI: self.conversion}
        if function is Function.CONTROL and self._scripts:
            script[function] = self._scripts.script(robot)
        call = ScriptCall(robot, Path(str(script[function] or CTC)).name, function)
        self._failed.append(call)
        self._launcher.report(Failed(call, text))

    def _loaded(self, scripts: LawScripts) -> list[ControlLaw]:
        """Return a new law for each robot, and publish their task, or raise SetcmasError."""
        seed_scripts(self._seed, self.robots[0])
        laws = []
        for robot in self.robots:
            script = scripts.script(robot)
            with self.watch.call(robot, script, Function.LOADING):
                laws.append(ControlLaw(script, robot, self.nb_robots, scripts.settings[script]))
            if not rclpy.ok():
                raise SetcmasError(
                    f'{script.name} has shut down ROS while loading: remove rclpy.shutdown'
                )
        with self.watch.call(laws[0].robot, laws[0].path, Function.LOADING):
            named = [(law.names, law.path) for law in laws]
            if references := references_of_fleet(named, self.nb_robots, self._warn):
                self._task.publish(String(data=references.encoded()))
        return laws

    def reload(self) -> None:
        """Load the laws again; there are none if one does not load, which raises SetcmasError."""
        self.laws, self.reports = [], self._new_reports()
        if self._scripts:
            self.laws = self._loaded(self._scripts)

    def broadcast(self, robot: int) -> Broadcast:
        """Return a newly loaded condition of a robot, or raise SetcmasError."""
        with self.watch.call(robot, self.condition or Path(CTC), Function.LOADING):
            return self.communication.broadcast(robot, self.reports[Function.CONDITION])

    @property
    def failed(self) -> tuple[ScriptCall, ...]:
        """Calls that have failed or hung at some time, and scripts that did not load again."""
        unloaded = []
        if self._scripts and not self.laws:
            names = [(robot, self._scripts.script(robot).name) for robot in self.robots]
            unloaded = [ScriptCall(*name, Function.LOADING) for name in names]
        return tuple(dict.fromkeys([*self._failed, *self.watch.have_been_stuck, *unloaded]))

    def report_end(self) -> None:
        """Report to the launcher what has failed, and when: in later versions t began again."""
        failures = [one for reports in self._first_reports.values() for one in reports.failures]
        failures.sort(key=attrgetter('t'))
        self._launcher.report(Ended(self.failed, tuple(failures)))
