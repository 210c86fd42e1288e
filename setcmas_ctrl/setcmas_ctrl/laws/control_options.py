"""Options of a controller, the same for `setcmas ctrl` and for the node's own command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from setcmas_ctrl.laws.script_loader import ALGORITHMS, compile_script
from setcmas_ctrl.laws.script_search import LawScripts, find_script
from setcmas_ctrl.laws.script_seeds import SEED
from setcmas_ctrl.laws.script_settings import parse_setting
from setcmas_simu import option_kinds as kinds
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import check_in_fleet, format_robots
from setcmas_simu.fleet.topics import AUTO, CMD_VEL_TYPES
from setcmas_simu.option_groups import Form, Options, flag, option
from setcmas_simu.robots.model import VelocityLimits

Law = str | Path | Callable[..., Any]
Algo = Law | Mapping[int, Law]
"""A control law of all robots, or a law for each."""

SI_TO_UNI = 'si_to_uni(velocity, pose, komega)'
"""The function that a script for `--si-to-uni` must define."""

GivenConversion = str | Path | Callable[..., Any] | Mapping[int, Callable[..., Any]] | None
"""A script, a function, or a function for each robot; None is the built-in si_to_uni."""

VNOM = 0.5
"""Default speed limit of robots, in m/s."""

KOMEGA = 1.5
"""Default gain on the heading error, in 1/s."""

RATE_HZ = 5.0
"""Default rate of control, in Hz."""

PAUSE_TIMEOUT_S = 0.5
"""Longest silence of the pause node, in s, before robots stop."""

EXTERNAL = 'external'
"""In place of a control law: another program publishes the velocities (cmd_cart_vel)."""

SCRIPT_FAILED = 1
"""Exit status after a control script has failed for some robot."""


@dataclass(frozen=True, kw_only=True)
class GainOptions(Options):
    """Speed limit, gain, control rate and seed."""

    TITLE: ClassVar[str] = 'control law'

    vnom: float = option(
        kinds.Number(above=0, unit='m/s'), 'speed limit of the robots', default=VNOM
    )
    komega: float = option(
        kinds.Number(above=0, unit='1/s', finite=True, metavar='GAIN'),
        'gain on the heading error',
        default=KOMEGA,
    )
    rate: float = option(kinds.RATE, 'control rate', default=RATE_HZ)
    seed: int = option(
        kinds.SEEDS, 'seed of random numbers in scripts, links and start poses', default=SEED
    )


@dataclass(frozen=True)
class _LawName(kinds.NameOrFile):
    """Names and files of control laws; in Python also functions, and a law for each robot."""

    must_be = 'a control law by name, a script, or in Python a function'

    def accepts(self, value: Any) -> bool:
        return isinstance(value, (str, Mapping)) or callable(value)


@dataclass(frozen=True)
class _Settings(kinds.Kind):
    """Values for names of a script: typed as 'kp=1.2', a mapping in YAML and Python."""

    must_be = 'a mapping from names of the script to values, such as {K: 1.2}'
    gather = dict

    def value(self, given: Any) -> Any:
        if isinstance(given, str):
            return parse_setting(given)
        return dict(given) if isinstance(given, Mapping) else given

    def accepts(self, value: Any) -> bool:
        return isinstance(value, tuple) and len(value) == 2 and str(value[0]).isidentifier()


@dataclass(frozen=True, kw_only=True)
class LawOptions(GainOptions):
    """Control law, its settings, and how its velocities become commands."""

    algo: Algo = option(
        _LawName(metavar='NAME'),
        'control law: a path, NAME.py in this folder, a built-in law (see setcmas list), or '
        'external: another program publishes velocities on cmd_cart_vel; or '
        "one per robot: '1:leader.py,2-8:follower.py'",
    )
    exercise: bool = flag('run the exercise version of --algo instead of the law')
    set: Mapping[str, Any] = option(
        _Settings(metavar='NAME=VALUE'),
        'set a module-level variable of the script, such as kp=1.2; values computed from it '
        'change too; may be repeated',
        form=Form.REPEATED,
        default={},
    )
    si_to_uni: GivenConversion = option(
        kinds.ScriptOrFunction(metavar='FILE'),
        f'script with your own {SI_TO_UNI}: a path or a name',
        default=None,
        default_text='turn towards the velocity of the law, and drive at its speed',
    )

    def scripts(self) -> LawScripts:
        """Return the control scripts, which can be compiled, or raise SetcmasError."""
        if self.is_external:
            raise SetcmasError(
                f'--algo {EXTERNAL} is for setcmas ctrl, as velocities come over ROS; here --algo '
                'must be a control law'
            )
        return LawScripts(str(self.algo), self.exercise, self.set)

    @property
    def is_scripts(self) -> bool:
        """Whether all laws are scripts, and none a function."""
        return isinstance(self.algo, str) and self.algo not in ('', EXTERNAL)

    @property
    def is_external(self) -> bool:
        """Whether another program publishes the velocities."""
        return self.algo == EXTERNAL

    def check(self) -> None:
        """Check that there is a script to take settings."""
        laws = self.algo.values() if isinstance(self.algo, Mapping) else [self.algo]
        if self.set and all(map(callable, laws)):
            raise SetcmasError('set is for scripts; a function takes none')
        if self.set and self.is_external:
            raise SetcmasError(f'--set is for control laws; --algo {EXTERNAL} has none')

    def arguments(self, *others: Options) -> list[str]:
        """Return the same as `Options.arguments`, with the path of a built-in law.

        Looking for it again would take the child process 0.03 s and 2.5 MB (importlib.metadata;
        benchmarks/fleet.py, 2 cores of an AMD EPYC). Other names stay: the process runs in the
        same folder, whose path ROS may not be able to send.
        """
        law = self
        if self.is_scripts and str(self.algo) in ALGORITHMS:
            law = replace(self, algo=str(find_script(str(self.algo), self.exercise)))
        return Options.arguments(law, *others)

    def check_laws(self, nb_robots: int | None) -> None:
        """Raise SetcmasError if a robot has no script, or one that cannot be compiled."""
        if self.is_scripts:
            scripts = LawScripts(str(self.algo), self.exercise)
            if nb_robots is not None:
                scripts.check(nb_robots)

    def conversion(self) -> GivenConversion:
        """Return `si_to_uni` with the path of a script, or raise SetcmasError."""
        if not isinstance(self.si_to_uni, (str, Path)):
            return self.si_to_uni
        return find_script(str(self.si_to_uni), self.exercise, (), '--si-to-uni', SI_TO_UNI)

    def check_conversion(self) -> None:
        """Raise SetcmasError if the script of `si_to_uni` cannot be compiled."""
        if isinstance(path := self.conversion(), Path):
            compile_script(path, SI_TO_UNI)

    def check_settings(self) -> None:
        """Check that the scripts have the names of `set`, or raise SetcmasError."""
        if self.is_scripts and self.set:
            self.scripts()


@dataclass(frozen=True, kw_only=True)
class WatchOptions(Options):
    """Reload of control scripts at run time."""

    TITLE: ClassVar[str] = 'control law'

    watch: bool = flag(
        'reload the script whenever you save it; its variables and t start again, the robots '
        'stay where they are (in experiments only while paused)'
    )


@dataclass(frozen=True, kw_only=True)
class FleetOptions(Options):
    """Which robots are controlled, and how they listen."""

    TITLE: ClassVar[str] = 'fleet'

    nb_robots: int | None = option(
        kinds.NB_ROBOTS, 'size of the fleet', default=None, default_text='as announced on /fleet'
    )
    robots: tuple[int, ...] | None = option(
        kinds.Robots(), "control only these robots of the fleet, such as '1-4'", default=None
    )
    model: str | None = option(
        kinds.Kind(metavar='MODEL'),
        'robot model, as for setcmas simu',
        default=None,
        default_text='as the simulator announces',
    )
    cmd_vel_type: str = option(
        kinds.OneOf((AUTO, *CMD_VEL_TYPES)),
        'message type of cmd_vel',
        default=AUTO,
        default_text=f'{AUTO}, the type that each robot listens to',
    )

    def controlled(self, nb_robots: int) -> list[int]:
        """Return the controlled robots; raise SetcmasError if one is not in the fleet."""
        robots = list(self.robots or range(1, nb_robots + 1))
        check_in_fleet(robots, nb_robots, f"--robots '{format_robots(robots)}'")
        return robots


@dataclass(frozen=True)
class _Limits(kinds.Kind):
    """Limits of a robot as numbers."""

    must_be = 'four numbers: forward, turn and wheel speed, and distance of the wheels'

    def value(self, given: Any) -> Any:
        try:
            return VelocityLimits(
                *map(float, given.split(',') if isinstance(given, str) else given)
            )
        except (TypeError, ValueError):
            return given

    def accepts(self, value: Any) -> bool:
        return isinstance(value, VelocityLimits)


@dataclass(frozen=True, kw_only=True)
class ControllerOptions(FleetOptions, WatchOptions):
    """Options for a controller process from the command that starts it."""

    experiment: bool = flag(
        'control real robots: poses from motion capture, commands to the cmd_vel bridge'
    )
    pause_timeout: float = option(
        kinds.Number(above=0, unit='s', finite=True),
        'longest silence of the pause node before robots stop',
        default=PAUSE_TIMEOUT_S,
    )
    limits: VelocityLimits | None = option(
        _Limits(metavar='V,OMEGA,WHEEL,SEPARATION'), 'how fast unicycles can go', default=None
    )
    recorded: bool = flag('wait for a recorder, so that it gets the very first command')
