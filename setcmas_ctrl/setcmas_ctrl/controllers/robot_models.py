"""Models of the robots of a process: chosen by the user, or as their simulator announces."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from setcmas_ctrl.si_to_uni_node import SiToUni
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.announcement import Announcement
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.robots.models import is_script, model_names, robot_models
from setcmas_simu.ros.fleet_topic import FleetListener


class DrivenModels:
    """Sets the models of the robots that si_to_uni commands."""

    def __init__(self, drivers: Sequence[SiToUni], warn: Callable[[str], None]) -> None:
        self._drivers = {driver.robot: driver for driver in drivers}
        self._warn = warn
        self._taken: list[Announcement] = []
        self._reported: set[str] = set()

    def use(self, text: str, nb_robots: int) -> None:
        """Use the models in the value of `--model`, for a fleet of this size.

        Raises:
            SetcmasError: A model is unknown, or a script does not load.
        """
        robots, names = list(self._drivers), model_names(text, nb_robots)
        self._set(robots, [names[robot - 1] for robot in robots])

    def follow(self, announced: FleetListener) -> None:
        """Use the announced models, if there is a new announcement."""
        if announced.announcements is self._taken:
            return
        self._taken, models = announced.announcements, announced.models
        for name in dict.fromkeys(models.values()):
            robots = [robot for robot in self._drivers if models.get(robot) == name]
            try:
                if is_script(name):
                    raise SetcmasError(f'if {name} defines command(), add --model {name}')
                self._set(robots, [name] * len(robots))
            except SetcmasError as error:
                self._report(name, robots, error)

    def _set(self, robots: list[int], names: list[str]) -> None:
        models = robot_models(names, robots, warn=self._warn)
        for robot, model in zip(robots, models, strict=True):
            self._drivers[robot].use(model)

    def _report(self, name: str, robots: list[int], error: SetcmasError) -> None:
        if robots and name not in self._reported:
            self._reported.add(name)
            self._warn(
                f'{robots_in_words(sorted(robots))}: the simulator '
                f"announces model '{name}'; driven as unicycles: {error}"
            )
