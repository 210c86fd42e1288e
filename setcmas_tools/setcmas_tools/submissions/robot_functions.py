"""Functions of robots, called alike: control laws, triggering conditions and si_to_uni.

Arguments and numbers of a `RobotFunction`:

    control law   poses, t, adjacency matrix            vx, vy
    condition     pos, vit, last_pos, last_vit, t       1 or 0
    si_to_uni     velocity, pose, komega                V, omega
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from setcmas_ctrl import network
from setcmas_ctrl.communication.triggering_conditions import CTC as CONDITION
from setcmas_ctrl.communication.triggering_conditions import takes_velocities, triggering
from setcmas_ctrl.control_law import ControlLaw
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.si_to_uni_script import load_conversion
from setcmas_simu.arrays import Floats
from setcmas_simu.script_calls import Function

RobotFunction = Callable[..., tuple[float, ...]]


def robot_function(
    function: Function, script: Any, robot: int, nb_robots: int, settings: Mapping[str, Any]
) -> RobotFunction:
    """Load the path of a script, or take its function, for a robot.

    Raises:
        SetcmasError: It does not load, or takes other arguments.
    """
    if function is Function.CONTROL:
        return ControlLaw(script, robot, nb_robots, settings)
    if function is Function.SI_TO_UNI:
        return load_conversion(script, robot)
    path, condition = Path('ctc'), script
    if isinstance(script, Path):
        path, condition = script, vars(load_script(script, robot, CONDITION)).get('ctc')
    step = 1 if takes_velocities(condition, path.name) else 2
    triggers = triggering(condition, path)

    def ctc(*arguments: Any) -> tuple[float, ...]:
        *states, t = arguments
        return triggers(*states[::step], t)

    return ctc


def asking(function: Function, ask: RobotFunction) -> Callable[..., Any]:
    """Return a function as the engine calls it, which asks another for the numbers."""
    if function is Function.SI_TO_UNI:

        def si_to_uni(velocity: Any, pose: Any, komega: float) -> tuple[float, ...]:
            return ask(velocity, pose, komega)

        return si_to_uni
    if function is Function.CONDITION:

        def ctc(pos: Floats, vit: Floats, last_pos: Floats, last_vit: Floats, t: float) -> bool:
            return ask(pos, vit, last_pos, last_vit, t)[0] != 0.0

        return ctc

    def control(robotNo: int, nbRobots: int, poses: Floats, t: float) -> tuple[float, ...]:
        del robotNo, nbRobots
        return ask(poses, t, network.adjacency())

    return control
