"""run.yaml: scenario, origin and outcome of a run."""

from __future__ import annotations

import functools
import platform
import subprocess
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field, replace
from enum import Enum
from pathlib import Path
from typing import Any

from setcmas_simu import __version__
from setcmas_simu.errors import SetcmasError
from setcmas_simu.fleet.fleet import robots_in_words
from setcmas_simu.option_groups import plain
from setcmas_simu.plugins import plugin_versions
from setcmas_simu.script_calls import ScriptFailure
from setcmas_simu.yaml_entries import read_entries, write_yaml

FORMAT = 1


_PACKAGES = ('numpy', 'rclpy', 'rosbags', 'matplotlib', 'daqp')
_ROOT = Path(__file__).parents[3]
_GIT_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class Origin:
    """Versions and machine of a run.

    Attributes:
        setcmas: The release of setcmas, or the commit of a checkout.
        versions: Those of Python, of packages, and of all installed plugins.
        host: Name and system of the machine.
    """

    setcmas: str
    versions: dict[str, str]
    host: dict[str, str]


@functools.cache
def this_origin() -> Origin:
    """Return the origin of runs of this process."""
    found = {name: version for name in _PACKAGES if (version := _version(name))}
    return Origin(
        _commit() or __version__,
        {'python': platform.python_version(), **found, **plugin_versions()},
        {'name': platform.node(), 'system': platform.platform()},
    )


def _version(package: str) -> str | None:
    from importlib import metadata  # slow, and needed only where a run is written

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _commit() -> str | None:
    """Return release and commit of the checkout that this is; None if it is installed."""
    if not (_ROOT / '.git').exists():
        return None
    command = ['git', '-C', str(_ROOT), 'describe', '--always', '--dirty', '--abbrev=12']
    try:
        found = subprocess.run(
            [*command, '--exclude=*'],
            capture_output=True,
            text=True,
            timeout=_GIT_TIMEOUT_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return f'{__version__}, commit {found.stdout.strip()}'


class RunState(Enum):
    """End of a run."""

    NOT_FINISHED = 'not finished'
    """It is running, or was killed."""
    COMPLETE = 'complete'
    FAILED = 'failed'
    """It is complete, but a script failed for some robots."""
    NOT_STARTED = 'not started'
    """The robots did not start."""
    STOPPED = 'stopped'
    """The user has stopped it."""
    DIED = 'died'
    """A process of it has died."""


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes:
        failed: The robots for which each script failed at some time, by its file name.
        detail: Further details, such as which process died and why.
    """

    state: RunState
    failed: dict[str, list[int]] = field(default_factory=dict)
    detail: str = ''

    def __str__(self) -> str:
        """Return a text such as 'complete, but law.py failed for robot 2'."""
        if self.state is RunState.FAILED:
            failures = [
                f'{name} failed for {robots_in_words(robots)}'
                for name, robots in self.failed.items()
            ]
            return f'complete, but {" and ".join(failures) or "a script failed for some robots"}'
        text = {RunState.STOPPED: 'stopped by the user'}.get(self.state, self.state.value)
        return f'{text}: {self.detail}' if self.detail else text

    @classmethod
    def of_calls(cls, failed: Iterable[tuple[str, int]]) -> Outcome:
        """Return the outcome of a run that lasted its whole duration.

        Failed calls are given as name of the script's file, and number of the robot.
        """
        robots: dict[str, list[int]] = {}
        for script, robot in sorted(set(failed)):
            robots.setdefault(script, []).append(robot)
        return cls(RunState.FAILED if robots else RunState.COMPLETE, robots)


INFO_FILE = 'run.yaml'
_SHOWN = ('algo', 'nb_robots', 'duration', 'seed')


@dataclass(frozen=True)
class RunInfo:
    """Content of run.yaml.

    Attributes:
        command: The command line; empty for a run made in Python.
        outcome: How it ended.
        scenario: The scenario, from `Scenario.record`; files are paths in the folder of the run.
        lab: Values of an emulated lab that replace those of the scenario.
        started: When, such as '2026-11-21T16:02:11+0000'; None if unknown, so that equal
            runs leave equal files.
        origin: Versions and machine; None is this process.
        failures: Failures of scripts with robot and time; None if none, or if unknown.
    """

    command: list[str] = field(default_factory=list)
    outcome: Outcome = field(default_factory=lambda: Outcome(RunState.COMPLETE))
    scenario: dict[str, Any] = field(default_factory=dict)
    lab: dict[str, Any] | None = None
    started: str | None = None
    origin: Origin | None = None
    failures: list[ScriptFailure] | None = None

    def __repr__(self) -> str:
        """Return one line."""
        texts = (f'{name}={self.scenario[name]}' for name in _SHOWN if name in self.scenario)
        return f'RunInfo({", ".join([*texts, str(self.outcome)])})'

    @property
    def seed(self) -> int:
        """Seed of the random numbers of scripts, links and start poses."""
        return int(self.scenario.get('seed', 0))

    @property
    def parameters(self) -> dict[str, Any]:
        """The values of the scenario by name, those of the lab in place of its own."""
        values = {name: value for name, value in self.scenario.items() if name != 'version'}
        return values | (self.lab or {})


def write_info(info: RunInfo, folder: Path) -> None:
    """Write run.yaml, whole or not at all, or raise OSError."""
    known = replace(info, origin=info.origin or this_origin())
    content = plain(asdict(known, dict_factory=_without_none))
    content['outcome'] = {name: value for name, value in content['outcome'].items() if value}
    write_yaml({'format': FORMAT, **content}, folder / INFO_FILE)


def _without_none(fields: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return the fields of a record that are known, as values of YAML."""
    values = {name: one.value if isinstance(one, Enum) else one for name, one in fields}
    return {name: value for name, value in values.items() if value is not None}


def read_info(folder: Path) -> RunInfo | None:
    """Read the run.yaml of a folder; None if there is none.

    Raises:
        SetcmasError: The file cannot be read, is damaged, or is of another format.
    """
    import msgspec  # late: the page in a browser reads no run.yaml

    from setcmas_tools.run.scenario import OF_RUN, Scenario  # late: not needed for tables

    path = folder / INFO_FILE
    if not path.exists():
        return None
    content = read_entries(path)
    values = content.plain() if isinstance(content.value, dict) else {}
    found = str(values.pop('format', 'none'))[:40]
    if found != str(FORMAT):
        raise SetcmasError(f"'{path}' has format {found}; this setcmas reads format {FORMAT} only")
    try:
        info = msgspec.convert(values, RunInfo)
    except msgspec.ValidationError as error:
        raise SetcmasError(f"'{path}' is damaged: {error}") from error
    if info.scenario:
        Scenario.recorded(content.value[OF_RUN], has_files=False)
    return info
