"""Models by which robots are driven: those of --model, else those that are announced."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from setcmas_ctrl.driving.si_to_uni import SiToUni
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.messages.fleet_topic import FleetListener
from setcmas_simu.robots.models import is_script, robot_models


class DrivenModels:
    """Gives the nodes that command robots the robots' models."""

    def __init__(self, followers: Sequence[SiToUni], warn: Callable[[str], None]) -> None:
        """Take the nodes, which drive unicycles so far; `warn` shows a message to the user."""
        self._followers = {follower.robot: follower for follower in followers}
        self._warn = warn
        self._told: set[str] = set()

    def use(self, names: Sequence[str]) -> None:
        """Drive the robots by models, one name for each robot of the fleet.

        Raises:
            SetcmasError: There is no such model, or a script cannot be loaded.
        """
        robots = list(self._followers)
        models = robot_models([names[robot - 1] for robot in robots], robots, warn=self._warn)
        for robot, model in zip(robots, models, strict=True):
            self._followers[robot].model = model

    def follow(self, announced: FleetListener) -> None:
        """Drive the robots by the models that are announced, now and later."""
        announced.on_change = lambda: self._take(announced.models)
        self._take(announced.models)

    def _take(self, models: Mapping[int, str]) -> None:
        for name in dict.fromkeys(models.values()):
            robots = [robot for robot in self._followers if models.get(robot) == name]
            try:
                if is_script(name):
                    raise SetcmasError(f'if {name} has a command of its own, add --model {name}')
                for robot, model in zip(
                    robots, robot_models([name] * len(robots), robots), strict=True
                ):
                    self._followers[robot].model = model
            except SetcmasError as error:
                self._tell(name, robots, error)

    def _tell(self, name: str, robots: list[int], error: SetcmasError) -> None:
        if robots and name not in self._told:
            self._told.add(name)
            self._warn(
                f'{robots_in_words(sorted(robots))}: the simulator '
                f"says '{name}'; driven as unicycles: {error}"
            )
