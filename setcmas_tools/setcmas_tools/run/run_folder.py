"""Folder of a run, the copies in it of files that the run was given, and paths that name a run."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from setcmas_ctrl.laws.script_imports import MOST_BYTES, with_helpers
from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.limited_file import read_limited
from setcmas_simu.option_groups import Options, flag, option
from setcmas_simu.option_kinds import Number, PathTo
from setcmas_tools.run.run_info import INFO_FILE, RunInfo, write_info
from setcmas_tools.run.run_tables import FLEET, RunTables, write_tables
from setcmas_tools.run.scenario import Scenario
from setcmas_tools.run.scenario_files import INPUTS, OF_FILES, robots_by_text


@dataclass(frozen=True, kw_only=True)
class RunOptions(Options):
    """Output of a run."""

    output: Path | None = option(
        PathTo(metavar='DIR'), 'folder for the results', default=None, short='-o'
    )
    plots: bool = flag('draw the plots, or skip them (default: draw them)', default=True)
    overwrite: bool = flag('replace an earlier run in that folder')


@dataclass(frozen=True, kw_only=True)
class OfflineOptions(Options):
    """Options of offline runs."""

    call_timeout: float = option(
        Number(above=0, unit='s'),
        'end the run if one call of the script takes longer than this',
        default=10.0,
    )


BAG_ENDINGS = ('.mcap', '.db3', '.bag')


def stem_of_bag(bag: Path) -> str:
    """Return the prefix of the names of a bag's files; none for a folder named `bag`.

    It has the ending of a file next to other bags of its name, such as lab.bag and lab.mcap.
    """
    bag = bag.resolve()
    if bag.name == 'bag':
        return ''
    others = (bag.with_suffix(ending) for ending in ('', *BAG_ENDINGS))
    is_alone = sum(other.exists() for other in others) == 1
    return f'{bag.stem if bag.is_file() and is_alone else bag.name}_'


@dataclass(frozen=True)
class RunSource:
    """The files of a run.

    Attributes:
        folder: The folder of the run; it may hold a table or a bag only.
        fleet_csv: Its table; None if there is only a bag.
        bag: Its bag, if there is no table.
    """

    folder: Path
    fleet_csv: Path | None = None
    bag: Path | None = None

    @property
    def stem(self) -> str:
        """Prefix of the names of its files, as a folder may hold several runs."""
        if self.fleet_csv:
            own = self.fleet_csv.name == FLEET.name
            return '' if own else f'{self.fleet_csv.stem}_'
        assert self.bag
        return stem_of_bag(self.bag)

    @property
    def recording(self) -> Path | None:
        """Its bag, also where there is a table; None if there is none."""
        bag = self.bag or self.folder / 'bag'
        return bag if bag.exists() else None

    @property
    def plots(self) -> Path:
        """Default folder of its plots."""
        return self.folder / f'{self.stem}plots'


def find_run(path: Path) -> RunSource:
    """Return the files of a run: of its folder or that of its CSV files, a fleet.csv, or a bag.

    Raises:
        SetcmasError: There is no run, or the folder cannot be read.
    """
    with file_errors(f"'{path}' cannot be read"):
        return _found(path)


def _found(path: Path) -> RunSource:
    if path.is_file():
        if path.suffix in BAG_ENDINGS:
            return RunSource(path.resolve().parent, bag=path)
        return RunSource(_folder_of_csv(path), fleet_csv=path)
    for place in (path / 'csv' / FLEET.name, path / FLEET.name):
        if place.is_file():
            return RunSource(_folder_of_csv(place), fleet_csv=place)
    if not path.exists():
        raise SetcmasError(
            f"there is no '{path}'; it must be the folder of a run, a fleet.csv, or a bag"
        )
    if any(f.name == 'metadata.yaml' or f.suffix in BAG_ENDINGS for f in path.iterdir()):
        return RunSource(path.resolve().parent, bag=path)
    if (path / 'bag').is_dir():
        return RunSource(path, bag=path / 'bag')
    raise SetcmasError(f"there is no fleet.csv in '{path}' or in its folder csv, and no bag")


def _folder_of_csv(fleet_csv: Path) -> Path:
    """Return the folder of the run that a fleet.csv belongs to: above `csv`, else its own."""
    is_csv_folder = fleet_csv.resolve().parent.name == 'csv'
    return fleet_csv.parent.parent if is_csv_folder else fleet_csv.parent


class RunInput:
    """A file that an option names, and the modules that it imports.

    Attributes:
        option: Name of the option.
        robots: The robots that it is for; none if it is for all.
        files: The file, and if it is a script the modules of its folder that it imports.
        contents: The bytes of each of them.
    """

    def __init__(self, option: str, path: Path, robots: Sequence[int] = ()) -> None:
        """Read the file and its modules, or raise SetcmasError."""
        self.option = option
        self.path = path
        self.robots = tuple(robots)
        self.files = with_helpers(path)
        self.contents = [_read(file) for file in self.files]

    @property
    def folder(self) -> str:
        """Its folder in the folder of the run."""
        return f'{INPUTS}/{self.option}' + (f'_{self.robots[0]}' if self.robots else '')

    def write_to(self, folder: Path) -> None:
        """Write the files into a folder, modules in packages into such packages.

        Raises:
            OSError: A file cannot be written.
        """
        for file, content in zip(self.files, self.contents, strict=True):
            target = folder / file.relative_to(self.path.parent)
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)


def _read(file: Path) -> bytes:
    with file_errors(f"'{file}' cannot be read"):
        return read_limited(file, MOST_BYTES)


def inputs_of(scenario: Scenario) -> list[RunInput]:
    """Return the scripts and files that a scenario names, each with the robots that it is for.

    The scenario has absolute paths, as from `Scenario.found`; SetcmasError is raised for a file
    that cannot be read.
    """
    return [
        RunInput(name, Path(path), robots)
        for name in OF_FILES
        for path, robots in scenario.named(name).items()
        if Path(path).is_absolute()
    ]


def kept_record(scenario: Scenario, inputs: Iterable[RunInput]) -> dict[str, Any]:
    """Return the record of a scenario, which names its files where the folder of a run has them.

    It has the number of robots, given or not. The scenario has absolute paths, as from
    `Scenario.found`.
    """
    kept = {(one.option, str(one.path)): f'{one.folder}/{one.path.name}' for one in inputs}
    sized = scenario.replace(nb_robots=scenario.nb_robots)
    return sized.located(lambda name, text: kept.get((name, text), text)).record()


def kept_inputs(folder: Path, record: Mapping[str, Any]) -> tuple[RunInput, ...]:
    """Return the inputs that the folder of a run keeps, for the scenario in its run.yaml.

    Those that are missing are left out. A stranger's run.yaml may name any file: it must be a
    small one in inputs/, without links.
    """
    found = []
    for name in OF_FILES:
        for text, robots in robots_by_text(record.get(name)).items():
            if _is_kept(folder, Path(text)):
                with suppress(SetcmasError):  # too large
                    found.append(RunInput(name, folder / text, robots))
    return tuple(
        one
        for one in found
        if all(_is_kept(folder, file.relative_to(folder)) for file in one.files)
    )


def _is_kept(folder: Path, path: Path) -> bool:
    parts = path.parts
    if parts[:1] != (INPUTS,) or '..' in parts:
        return False
    places = [folder.joinpath(*parts[:count]) for count in range(1, len(parts) + 1)]
    return places[-1].is_file() and not any(place.is_symlink() for place in places)


STUDY_TABLE = 'runs.csv'
"""The file in the folder of a study with a row for each run."""

_PARTS = ('bag', 'csv', 'plots', INPUTS, 'metrics.yaml', STUDY_TABLE, INFO_FILE)


class RunFolder:
    """The folder of a run.

    Attributes:
        path: The folder.
        bag: The folder of the rosbag2 bag.
        csv: The folder of the CSV files.
        plots: The folder of the plots.
        metrics: The file of the metrics.
    """

    def __init__(self, path: Path, inputs: Sequence[RunInput] = ()) -> None:
        """Name the folder and the inputs of the run; nothing is created yet."""
        self.path = path
        self._inputs = inputs
        self.bag, self.csv, self.plots = (self.path / name for name in ('bag', 'csv', 'plots'))
        self.metrics = self.path / 'metrics.yaml'

    def summary(self, nb_plots: int) -> str:
        """Return a line with the folders of CSV files and plots."""
        plots = f'   {nb_plots} plots: {self.plots}' if nb_plots else ''
        return f'CSV: {self.csv}{plots}'

    def check(self, overwrite: bool) -> None:
        """Check that no earlier run or study would be lost.

        Raises:
            SetcmasError: The folder holds one that must not be overwritten, or files that are
                no run; or it is a file, or cannot be read.
        """
        with self._writing():
            if self.path.exists() and not self.path.is_dir():
                raise SetcmasError(f"output '{self.path}' is not a folder")
            taken = [part for part in _PARTS if (self.path / part).exists()]
        if taken and 'run.yaml' not in taken:
            raise SetcmasError(
                f"output '{self.path}' holds {', '.join(taken)} and no run.yaml, so it is not a "
                'run of setcmas; name another folder'
            )
        if taken and not overwrite:
            kind = 'study' if STUDY_TABLE in taken else 'run'
            raise SetcmasError(
                f"output '{self.path}' holds an earlier {kind}; "
                f'name another folder, or add --overwrite to replace that {kind}'
            )

    def create(self, info: RunInfo) -> None:
        """Create the folder with run.yaml and inputs; remove an earlier run or study.

        Raises:
            SetcmasError: The folder cannot be created or emptied.
        """
        with self._writing():
            self.path.mkdir(parents=True, exist_ok=True)
            self._remove_parts()
            self.write_info(info)
            for given in self._inputs:
                given.write_to(self.path / given.folder)

    def write_info(self, info: RunInfo) -> None:
        """Replace run.yaml, or raise SetcmasError."""
        with self._writing():
            write_info(info, self.path)

    def write_tables(self, tables: RunTables) -> None:
        """Write the CSV files, or raise SetcmasError."""
        with self._writing():
            self.csv.mkdir(exist_ok=True)
            write_tables(tables, self.csv)

    def discard(self) -> None:
        """Remove the parts of a run that did not start."""
        with suppress(OSError):
            self._remove_parts()
            self.path.rmdir()  # stays if the user has files of their own in it

    def _remove_parts(self) -> None:
        """Remove the files and folders of a run or study; of a link, only the link."""
        for target in (self.path / part for part in _PARTS):
            if target.is_dir() and not target.is_symlink():
                shutil.rmtree(target)
            else:
                target.unlink(missing_ok=True)

    def _writing(self) -> AbstractContextManager[None]:
        return file_errors(f"output '{self.path}' cannot be written")
