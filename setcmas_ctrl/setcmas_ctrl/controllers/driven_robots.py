"""The robots that the nodes si_to_uni of a process command: models, conversions, safety filter."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from setcmas_ctrl.controllers.fleet_scripts import FleetScripts
from setcmas_ctrl.controllers.markers import publish_obstacles
from setcmas_ctrl.filter.filter_options import FilterOptions
from setcmas_ctrl.fleet_poses import FleetPoses
from setcmas_ctrl.laws.control_options import ControllerOptions, GainOptions
from setcmas_ctrl.safety_filter_node import SafetyFilterNode
from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_ctrl.si_to_uni_script import ScriptConversion, script_conversions
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robots.models_by_name import is_script, model_names, robot_models
from setcmas_simu.ros.fleet_node import FleetNode
from setcmas_simu.ros.fleet_topic import Announcement, FleetListener
from setcmas_simu.script_calls import Function


class DrivenRobots:
    """The nodes si_to_uni of a process, and the safety filter before them.

    Attributes:
        nodes: The nodes si_to_uni, one per robot.
        stepped: The filter, if there is one, and the nodes, in the order of the steps.
    """

    def __init__(
        self,
        node: FleetNode,
        nodes: Sequence[SiToUni],
        poses: FleetPoses,
        scripts: FleetScripts,
        announced: FleetListener,
        gains: GainOptions,
        safety: FilterOptions,
        options: ControllerOptions,
    ) -> None:
        """Prepare the nodes of some robots; `poses` are those of the whole fleet.

        Raises:
            SetcmasError: A model or a script does not load, or the filter cannot guarantee safety.
        """
        self.nodes, self._scripts, self._announced = nodes, scripts, announced
        self._warn = node.get_logger().warning
        self._follows_models = options.model is None
        self._taken: list[Announcement] = []
        self._reported: set[str] = set()
        for one in nodes:
            one.poses = poses
        if options.model:
            names = model_names(options.model, poses.poses.shape[1])
            robots = [one.robot for one in nodes]
            self._use(robots, [names[robot - 1] for robot in robots])
        self.follow_models()
        self._filters: list[SafetyFilterNode] = []
        if safety.is_on and nodes:
            self._filters = [SafetyFilterNode(node, nodes, safety, gains, poses)]
        self.stepped: list[Any] = [*self._filters, *nodes]
        self.load_conversions()
        publish_obstacles(node, safety, options.experiment)

    def load_conversions(self) -> None:
        """Load the user's own si_to_uni for each robot, if there is one, or raise SetcmasError.

        The safety filter has its own copies.
        """
        for one, script in zip(self.nodes, self._conversions(), strict=False):
            one.convert_by(script)
        for safety_filter in self._filters:
            safety_filter.convert_by(self._conversions())

    def _conversions(self) -> list[ScriptConversion]:
        robots = [one.robot for one in self.nodes]
        scripts = self._scripts
        return script_conversions(
            scripts.conversion,
            robots,
            scripts.reports[Function.SI_TO_UNI],
            lambda: self.nodes[0].time.t,
            partial(scripts.watch.call, function=Function.SI_TO_UNI),
        )

    def expect(self, period: float) -> None:
        """Expect a velocity once per `period` in s; the acceleration of robots depends on it."""
        for one in self.stepped:
            one.expect(period)

    def forget(self) -> None:
        """Drop velocities of other programs that have waited for the start."""
        for one in self.stepped:
            one.forget()

    def step(self) -> None:
        """Follow velocities that have come from other programs."""
        for one in self.stepped:
            one.step()

    def repeat(self) -> None:
        """Repeat the last commands that are due."""
        for one in self.nodes:
            one.repeat()

    def follow_models(self) -> None:
        """Use the models of a new announcement, unless the user has chosen models."""
        announced = self._announced
        if not self._follows_models or announced.announcements is self._taken:
            return
        self._taken, models = announced.announcements, announced.models
        for name in dict.fromkeys(models.values()):
            robots = [one.robot for one in self.nodes if models.get(one.robot) == name]
            try:
                if is_script(name):
                    raise SetcmasError(f'if {name} defines command(), add --model {name}')
                self._use(robots, [name] * len(robots))
            except SetcmasError as error:
                self._report(name, robots, error)

    def _use(self, robots: Sequence[int], names: Sequence[str]) -> None:
        """Use models for robots, or raise SetcmasError if one is unknown or does not load."""
        nodes = {one.robot: one for one in self.nodes}
        models = robot_models(names, robots, warn=self._warn)
        for robot, model in zip(robots, models, strict=True):
            nodes[robot].use(model)

    def _report(self, name: str, robots: list[int], error: SetcmasError) -> None:
        if robots and name not in self._reported:
            self._reported.add(name)
            self._warn(
                f'{robots_in_words(sorted(robots))}: the simulator '
                f"announces model '{name}', but si_to_uni drives them as unicycles: {error}"
            )
