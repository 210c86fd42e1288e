"""Options of a guard."""

from __future__ import annotations

from dataclasses import dataclass

from setcmas_expe.guard.commands import SILENCE_S
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.options.group import Options, flag, option
from setcmas_simu.options.kinds import DURATION, Number, OneOf
from setcmas_simu.robots.velocity_limits import MODELS

ACCEL = 2.5
"""Default acceleration of a wheel in m/s^2. ROBOTIS' navigation stack plans a Burger with 3.0
and brakes it with 2.5 (turtlebot3_navigation2, param/jazzy/burger.yaml)."""


@dataclass(frozen=True, kw_only=True)
class GuardOptions(Options):
    """What a guard listens to, and what it lets through."""

    cmd_vel_type: str = option(
        OneOf((AUTO, *CMD_VEL_TYPES)),
        'message type of cmd_vel',
        default=AUTO,
        default_text=f'{CMD_VEL_TYPES[0]}; of a base that hears cmd_vel itself, what it takes',
    )
    silence: float = option(
        DURATION,
        'silence from which the robot is stopped',
        default=SILENCE_S,
    )
    limits: str = option(OneOf(tuple(MODELS)), 'how fast the robot may be', default='burger')
    accel: float = option(
        Number(above=0, unit='m/s^2', finite=True),
        'how soon a wheel may gain speed',
        default=ACCEL,
    )
    resume: bool = flag('follow again after a silence, without anybody who starts the robot again')
