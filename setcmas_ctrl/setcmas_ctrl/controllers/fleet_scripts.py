"""The scripts of a process of controllers: laws, triggering conditions and conversions."""

from __future__ import annotations

from pathlib import Path

import rclpy
from std_msgs.msg import String

from setcmas_ctrl.communication.communication_options import (
    CommunicationOptions,
    chosen_communication,
)
from setcmas_ctrl.communication.triggering_conditions import CTC, Broadcast
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.call_watch import CallWatch
from setcmas_ctrl.laws.control_options import LawOptions
from setcmas_ctrl.laws.references import references_of_fleet
from setcmas_ctrl.laws.script_search import LawScripts
from setcmas_ctrl.laws.script_seeds import seed_scripts
from setcmas_ctrl.script_outcomes import ScriptOutcomes
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet import topics
from setcmas_simu.ros import qos
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.process import RosProcess
from setcmas_simu.script_calls import Function


class FleetScripts:
    """Loads the scripts of a process's robots, each time with fresh state.

    Attributes:
        robots: Numbers of the robots.
        nb_robots: Size of the fleet.
        watch: Times the calls of scripts.
        communication: How the robots communicate.
        laws: The control laws; none where other programs publish the velocities.
        outcomes: Errors of the scripts.
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
        warn = node.get_logger().warning
        self.robots, self.nb_robots, self._seed = robots, nb_robots, law.seed
        self.communication = chosen_communication(nb_robots, communication, law.seed)
        self.condition = self.communication.condition_script
        self.conversion = law.conversion()
        self.watch = CallWatch(warn, process.launcher)
        process.on_stop_signal = self.watch.stop_call
        self._warn = warn
        self._task = node.create_publisher(String, topics.TASK, qos.LATCHED)
        self._scripts = scripts
        self.laws: list[ControlLaw] = []
        if scripts:
            scripts.check(nb_robots)
            self.laws = self._loaded(scripts)
        self.outcomes = ScriptOutcomes(
            warn,
            self.watch,
            process.launcher,
            {one.robot: one.path for one in self.laws},
            robots,
            self.condition or Path(CTC),
            Path(str(self.conversion)),
        )

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
        self.laws = []
        if self._scripts:
            self.laws = self._loaded(self._scripts)

    def broadcast(self, robot: int) -> Broadcast:
        """Return a newly loaded condition of a robot, or raise SetcmasError."""
        with self.watch.call(robot, self.condition or Path(CTC), Function.LOADING):
            return self.communication.broadcast(robot, self.outcomes.conditions)
