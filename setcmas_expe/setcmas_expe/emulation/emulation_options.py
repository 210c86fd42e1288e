"""Options of the emulated lab, for every command that starts one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from setcmas_expe.lab.lab import Mocap
from setcmas_expe.mocap.sources import STANDARD
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import start_poses
from setcmas_simu.fleet.start_poses import RandomPoses
from setcmas_simu.option_groups import option
from setcmas_simu.option_kinds import SEEDS, Kind
from setcmas_simu.robots.arena import Arena
from setcmas_simu.robots.model import RobotModel
from setcmas_simu.robots.models_by_name import (
    UNICYCLE,
    fleet_model,
    is_model_file,
    model_names,
    robot_models,
)
from setcmas_simu.simulation_options import StartPoseOptions

_MARGIN = 0.5  # m, between start poses and the border of the arena
_HALF_SQUARE = 5.0  # m, of the default start poses


@dataclass(frozen=True, kw_only=True)
class EmulationOptions(StartPoseOptions):
    """How to emulate a lab."""

    model: str | None = option(
        Kind(metavar='FILE'),
        'model file of the robots, from setcmas identify',
        default=None,
        default_text='at once',
    )
    seed: int = option(SEEDS, 'seed of noise and of random start poses', default=0)

    def robot_model(self, robots: Sequence[int]) -> RobotModel | None:
        """Return how robots of these numbers follow commands; None if at once.

        Raises:
            SetcmasError: The model file is missing or has a mistake.
        """
        if self.model is None:
            return None
        names = model_names(self.model, max(robots))
        if strangers := [name for name in names if not (name == UNICYCLE or is_model_file(name))]:
            raise SetcmasError(
                f"--model '{strangers[0]}' cannot move emulated TurtleBot3s; it must be a "
                'model.yaml written by setcmas identify'
            )
        return fleet_model(robot_models([names[robot - 1] for robot in robots], robots))


def check_emulated_mocap(mocap: Mocap) -> None:
    """Check that a motion capture system can be emulated.

    Raises:
        SetcmasError: It does not send a topic per body, or messages that are not standard.
    """
    source = mocap.source
    standard = [message_type for message_type, _ in STANDARD.values()]
    if source.from_start or not source.per_body or source.message_type not in standard:
        raise SetcmasError(
            f'motion capture of an emulated lab must have a topic per body, with messages of type '
            f'{", ".join(STANDARD)}; {mocap.preset} sends {source.message_type} on '
            f'{source.topic}: add --mocap qualisys'
        )


def emulated_start_poses(
    arena: Arena, nb_robots: int, given: StartPoseOptions | None = None
) -> Floats:
    """Return x, y in m and theta in rad, shape (3, N): of a simulation, scaled to fit the arena.

    `given` poses are taken as they are.

    Raises:
        SetcmasError: A given pose is malformed or of no robot in the fleet, or there is no room
            for random ones.
    """
    defaults = start_poses(nb_robots)
    middle = np.array([[arena.xmin + arena.xmax], [arena.ymin + arena.ymax]]) / 2
    halves = np.array([[arena.xmax - arena.xmin], [arena.ymax - arena.ymin]]) / 2
    inner = np.maximum(halves - _MARGIN, 0.5 * halves)
    reach = max(_HALF_SQUARE, float(np.abs(defaults[:2]).max()))
    defaults[:2] = middle + np.minimum(1.0, inner / reach) * defaults[:2]

    def within(places: RandomPoses) -> RandomPoses:
        return places.within(*((x.item(), y.item()) for x, y in (middle, 2 * inner, 2 * halves)))

    return (given or StartPoseOptions()).start_poses(nb_robots, defaults, within)
