"""What a path to a run means: a folder of a run, of its CSV files, a fleet.csv, or a bag."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_tools.records import fleet_table

_BAG_ENDINGS = ('.mcap', '.db3', '.bag', '.active')


@dataclass(frozen=True)
class RunSource:
    """The files of a run.

    Attributes:
        folder: The folder of the run, which may hold nothing but a table or a bag.
        fleet_csv: Its table; None if there is only a bag.
        bag: Its bag, if there is no table.
    """

    folder: Path
    fleet_csv: Path | None = None
    bag: Path | None = None

    @property
    def stem(self) -> str:
        """What the names of files about it begin with, as there may be several in a folder."""
        if self.fleet_csv:
            own = self.fleet_csv.name == fleet_table.FILE_NAME
            return '' if own else f'{self.fleet_csv.stem}_'
        assert self.bag
        return stem_of_bag(self.bag)

    @property
    def plots(self) -> Path:
        """Where its plots go by default."""
        return self.folder / f'{self.stem}plots'


def stem_of_bag(bag: Path) -> str:
    """Return what the names of files about a bag begin with.

    The file of a recording loses its ending there, unless that is all that sets it apart from
    another recording in its folder.
    """
    bag = bag.resolve()
    if bag.name == 'bag':
        return ''
    if bag.is_dir():
        return f'{bag.name}_'
    others = {bag.with_suffix(ending) for ending in ('', *_BAG_ENDINGS)} - {bag}
    return f'{bag.name if any(other.exists() for other in others) else bag.stem}_'


def find_run(path: Path) -> RunSource:
    """Return the files of the run that a path means.

    Args:
        path: The folder of a run, the folder of its CSV files, a fleet.csv, or a bag.

    Raises:
        SetcmasError: There is no run.
    """
    if path.is_file():
        if path.suffix in _BAG_ENDINGS:
            return RunSource(path.resolve().parent, bag=path)
        return RunSource(_folder_of_csv(path), fleet_csv=path)
    for place in (path / 'csv' / fleet_table.FILE_NAME, path / fleet_table.FILE_NAME):
        if place.is_file():
            return RunSource(_folder_of_csv(place), fleet_csv=place)
    if not path.exists():
        raise SetcmasError(
            f"there is no '{path}'; it must be the folder of a run, a fleet.csv, or a bag"
        )
    if _is_bag(path):
        return RunSource(path.resolve().parent, bag=path)
    if (path / 'bag').is_dir():
        return RunSource(path, bag=path / 'bag')
    raise SetcmasError(f"there is no fleet.csv in '{path}' or in its folder csv, and no bag")


def _folder_of_csv(fleet_csv: Path) -> Path:
    """Return the folder of the run that a fleet.csv belongs to: above `csv`, else its own."""
    is_csv_folder = fleet_csv.resolve().parent.name == 'csv'
    return fleet_csv.parent.parent if is_csv_folder else fleet_csv.parent


def _is_bag(path: Path) -> bool:
    return any(f.name == 'metadata.yaml' or f.suffix in _BAG_ENDINGS for f in path.iterdir())
