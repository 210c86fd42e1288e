"""Loader of the control laws of a process: the first time, and whenever a script is saved."""

from __future__ import annotations

from collections.abc import Sequence

import rclpy

from setcmas_ctrl.control.control_law import ControlLaw
from setcmas_ctrl.control.law_scripts import LawScripts
from setcmas_ctrl.scripts.random_seed import seed_scripts
from setcmas_ctrl.scripts.watch.call_watch import CallWatch
from setcmas_ctrl.task.task_topic import TaskTopic
from setcmas_simu.errors import SetcmasError


class LawLoader:
    """Loads the laws of the robots of this process, each time with fresh state.

    Attributes:
        watch: Knows whether a script is stuck while it is loaded.
    """

    def __init__(
        self,
        scripts: LawScripts,
        seed: int,
        robots: Sequence[int],
        nb_robots: int,
        watch: CallWatch,
        task: TaskTopic,
    ) -> None:
        """Prepare.

        Args:
            scripts: The control scripts.
            seed: Chooses their random numbers.
            robots: The robots of this process.
            nb_robots: Size of the fleet.
            watch: Watches the scripts.
            task: Is told the task of the laws.
        """
        self.watch = watch
        self._scripts = scripts
        self._seed = (seed + robots[0] - 1) % 2**32  # in another process, other numbers
        self._robots = robots
        self._nb_robots = nb_robots
        self._task = task

    def load(self) -> list[ControlLaw]:
        """Return a new law of each robot, and tell their task.

        Raises:
            SetcmasError: A script cannot be loaded, or has shut ROS down.
        """
        seed_scripts(self._seed)
        laws = [self._law(robot) for robot in self._robots]
        with self.watch.loading(laws[0].robot, laws[0].path):
            self._task.tell(laws)
        return laws

    def _law(self, robot: int) -> ControlLaw:
        script = self._scripts.script(robot)
        with self.watch.loading(robot, script):
            law = self._scripts.law(robot, self._nb_robots)
        if not rclpy.ok():
            raise SetcmasError(
                f'{script.name} has shut ROS down while loading: leave out rclpy.shutdown'
            )
        return law
