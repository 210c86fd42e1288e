"""A run of a fleet: its tables, its options and outcome, its files; loaded, saved, shown."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError, needs
from setcmas_simu.fleet.fleet import is_per_robot, parse_per_robot
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.arena import Arena, Obstacles
from setcmas_simu.robots.models_by_name import UNICYCLE, model_names, symbol
from setcmas_tools.run.fleet_motion import LONGEST_GAP_S, FleetGrid, FleetTable, on_grid
from setcmas_tools.run.run_folder import RunFolder, RunInput, find_run, kept_inputs
from setcmas_tools.run.run_info import Outcome, RunInfo, RunState, read_info
from setcmas_tools.run.run_tables import RunTables, read_tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEASURE = 'setcmas_tools.measures.metrics:measure'
FIGURE = 'setcmas_tools.plots.plot:figure'
FILM = 'setcmas_tools.plots.film:film'
HTML = 'setcmas_tools.plots.plot:html'


def tool(target: str) -> Any:
    """Return a function by its module and name."""
    module, _, name = target.partition(':')
    return getattr(importlib.import_module(module), name)


@dataclass(frozen=True, repr=False, eq=False)
class Run(RunTables):
    """A run, simulated or real: its tables, and how it came about.

        run = Run.load('out')
        run['tb3_1'].x                   # of one robot, at run['tb3_1'].t
        run.poses[-1]                    # of all at the end: rows x, y, theta (simulated runs)
        run.plot('trajectories')

    Attributes:
        info: The content of run.yaml.
        inputs: The files that the run was given.
        bag: Its recording, where it was read from a folder or a bag.
    """

    info: RunInfo = field(default_factory=RunInfo)
    inputs: tuple[RunInput, ...] = ()
    bag: Path | None = None

    @classmethod
    def load(cls, path: str | Path, warn: Callable[[str], None] = print) -> Run:
        """Read a run.

        Args:
            path: Its folder, the folder of its CSV files, a fleet.csv, or a bag.
            warn: Prints losses; the motion is there all the same.

        Raises:
            SetcmasError: There is no run, or a table is damaged.
        """
        source = find_run(Path(path))
        if source.fleet_csv:
            tables = read_tables(source.fleet_csv)
        else:
            from setcmas_tools.run.run_samples import read_bag  # late: rosbags loads slowly

            assert source.bag
            tables = read_bag(source.bag, warn)
        try:
            info = read_info(source.folder) or RunInfo()
        except SetcmasError as error:
            warn(f'{error}; its parameters are not known')
            info = RunInfo()
        inputs = kept_inputs(source.folder, info.scenario)
        return cls(**vars(tables), info=info, inputs=inputs, bag=source.recording)

    def save(self, folder: str | Path, overwrite: bool = False) -> Path:
        """Write the run into a folder: run.yaml, csv/ and inputs/.

        Times keep 6 decimals, positions, headings and velocities 9; `Run.load` reads the rest as
        it was.

        Args:
            folder: Created if it is not there.
            overwrite: Whether to replace a run that is there.

        Returns:
            The folder.

        Raises:
            SetcmasError: It holds a run, or cannot be written.
        """
        target = RunFolder(Path(folder), self.inputs)
        target.check(overwrite)
        target.create(replace(self.info, outcome=Outcome(RunState.NOT_FINISHED)))
        target.write_tables(self)
        target.write_info(self.info)  # last: a full disk leaves no run that claims to be complete
        return target.path

    @property
    def parameters(self) -> Mapping[str, Any]:
        """The options of the run by name."""
        return self.info.parameters

    @property
    def outcome(self) -> Outcome:
        """How the run ended."""
        return self.info.outcome

    @cached_property
    def robots(self) -> list[int]:
        """The numbers of the robots, sorted."""
        return self.table.robots

    def __getitem__(self, robot: str | int) -> FleetTable:
        """Return the motion of a robot, such as run['tb3_1'] or run[1]: t, x, y, theta, v, omega.

        Raises:
            SetcmasError: It is not in the run.
        """
        for number in self.robots:
            if robot in (number, robot_name(number)):
                return self.table.of(number)
        names = ', '.join(map(robot_name, self.robots))
        raise SetcmasError(f"there is no robot '{robot}' in this run; it must be one of {names}")

    @property
    def t(self) -> Floats:
        """Times of the robots' states in s, shape (K,); of runs with common times (simulated)."""
        return self._stacked[0]

    @property
    def poses(self) -> Floats:
        """Rows x, y in m and theta in rad, shape (K, 3, N), at the times t."""
        return self._stacked[1]

    @property
    def V(self) -> Floats:  # noqa: N802 (the field's name)
        """Forward speeds over the step that led to each state in m/s, shape (K, N)."""
        return self._stacked[2]

    @property
    def omega(self) -> Floats:
        """Turn rates over that step in rad/s, shape (K, N)."""
        return self._stacked[3]

    @cached_property
    def _stacked(self) -> tuple[Floats, Floats, Floats, Floats]:
        found = self.table.stacked()
        if found is None:
            raise SetcmasError(
                "the robots of this run have states at different times: use run['tb3_1'].t "
                'and so on, or run.grid(), which interpolates'
            )
        t, _, x, y, theta, v, omega = found
        return t[:, 0], np.stack([x, y, theta], axis=1), v, omega

    @property
    def control_t(self) -> Floats:
        """Times at which the control laws were called in s, shape (C,), of simulated runs."""
        return self._stacked_commands[0]

    @property
    def velocities(self) -> Floats:
        """Velocities that they returned, after saturation: rows vx, vy in m/s, shape (C, 2, N)."""
        return self._stacked_commands[1]

    @cached_property
    def _stacked_commands(self) -> tuple[Floats, Floats]:
        found = self.commands.stacked() if self.commands else None
        if found is None:
            raise SetcmasError(
                'the robots of this run have commands at different times, or no known ones: '
                'use run.commands.of(1) and so on'
            )
        return found[0][:, 0], np.stack(found[2:4], axis=1)

    def grid(self, rate: float = 10.0) -> FleetGrid:
        """Return the poses at common times, interpolated at multiples of 1/rate (Hz)."""
        return on_grid(self.table, rate)

    @cached_property
    def counted(self) -> FleetTable:
        """The motion from the first command (t = 0) on, which metrics count."""
        return self.table.rows(self.table.t >= 0)

    @cached_property
    def counted_grid(self) -> FleetGrid:
        """The motion of those robots from t = 0 on at common times, 10 a second."""
        of_counted = np.isin(self.table.robot, self.counted.robots)
        # Poses at 0 are interpolated from rows before 0.
        near = self.table.rows(of_counted & (self.table.t >= -LONGEST_GAP_S))
        return on_grid(near).since(0.0)

    @property
    def failed_robots(self) -> list[int]:
        """The robots for which a script failed at some time, sorted."""
        return sorted({robot for robots in self.outcome.failed.values() for robot in robots})

    def metrics(self) -> Any:
        """Return the metrics of the run."""
        return tool(MEASURE)(self)

    def plot(self, name: str = 'trajectories') -> Figure:
        """Return a plot by its name.

        Raises:
            SetcmasError: There is no such plot, or it does not apply to this run.
        """
        figure: Figure = tool(FIGURE)(self, name)
        return figure

    def animate(self, **look: Any) -> Any:
        """Return a film; `kind`, `speed`, `size` and `dpi` as for csv_to_plot."""
        return tool(FILM)(self, **look)

    def to_dataframe(self) -> Any:
        """Return the motion as a pandas DataFrame with the columns of fleet.csv."""
        with needs('notebook'):
            import pandas as pd
        return pd.DataFrame(vars(self.table))

    @property
    def title(self) -> str:
        """Title in plots, such as 'consensus, 8 robots'."""
        number = f'{len(self.robots)} robot{"s" if len(self.robots) > 1 else ""}'
        algo = self.parameters.get('algo')
        return f'{law_title(str(algo))}, {number}' if algo else number

    def __repr__(self) -> str:
        duration = float(self.table.t[-1] - self.table.t[0])
        return f'Run({self.title}, {duration:g} s, {self.outcome})'

    def _repr_html_(self) -> str:
        return str(tool(HTML)(self))


def law_title(algo: str) -> str:
    """Return the names of control laws for a title, such as 'leader, follower'."""
    texts = parse_per_robot(algo, 'algo').values() if is_per_robot(algo) else [algo]
    stems = (text.replace('\\', '/').rpartition('/')[2].removesuffix('.py') for text in texts)
    title = ', '.join(dict.fromkeys(stems))
    return title if len(title) <= 40 else f'{title[:39]}…'


def arena_of(run: Run) -> Arena | None:
    """Return the arena of a run; None if it has none."""
    sides = run.parameters.get('arena')
    return Arena(*map(float, sides)) if sides else None


def obstacles_of(run: Run) -> Obstacles:
    """Return the obstacles of a run; it may have none."""
    return Obstacles.of(str(run.parameters.get('obstacles') or ''))


def models_of(run: Run) -> dict[int, str]:
    """Return the model of each robot of a run; unicycles by default."""
    names = [UNICYCLE] * max(run.robots)
    with suppress(SetcmasError):
        names = model_names(run.parameters.get('model'), max(run.robots))
    return {robot: names[robot - 1] for robot in run.robots}


def symbols_of(run: Run) -> dict[int, Floats]:
    """Return the outline of each robot, pointing along the x axis, shape (K, 2)."""
    return {robot: symbol(model) for robot, model in models_of(run).items()}
