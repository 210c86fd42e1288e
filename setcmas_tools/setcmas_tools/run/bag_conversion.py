"""Conversion of a bag to a CSV file for each topic, and the tables of its run."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path

from setcmas_simu.errors import SetcmasError, file_errors
from setcmas_simu.fleet.topics import TRIG_ODOM
from setcmas_tools.bags.bag_reader import Bag, open_bag
from setcmas_tools.bags.topic_table import TopicTable
from setcmas_tools.run.csv_columns import FLEET
from setcmas_tools.run.run_samples import RunSamples
from setcmas_tools.run.run_tables import FILE_NAMES, stem_of_bag, write_tables


@dataclass(frozen=True)
class ConversionReport:
    """Result of a conversion; as text, the lines to print.

    Attributes:
        folder: Folder of the files.
        files: One CSV file for each topic, sorted by topic.
        fleet: The fleet's table; None if the bag has no odometry of the fleet.
        messages: Number of rows of all topics.
        duration: From the first to the last message, in s.
        notices: A line for each loss in the bag.
    """

    folder: Path
    files: list[Path]
    fleet: Path | None
    messages: int
    duration: float
    notices: list[str]

    def __str__(self) -> str:
        fleet = f' and {self.fleet.name}' if self.fleet else ''
        number = len(self.files)
        plural = 's' if number != 1 else ''
        summary = (
            f'{self.messages:,} messages of {number} topic{plural}, {self.duration:.1f} s: '
            f'{number} CSV file{plural}{fleet} in {self.folder}'
        )
        return '\n'.join([*self.notices, summary])


def convert(bag: Path, output: Path | None = None) -> ConversionReport:
    """Write a CSV file for each topic of a bag, and the tables of the fleet and its communication.

    States on trig_odom, which are repeated until the next one is sent, have one row.
    Existing files of these names are replaced at the end, all at once.

    Args:
        bag: A path that `open_bag` accepts.
        output: Folder of the files; by default `csv` next to a bag folder named `bag`, else
            `<name of the bag>_csv` next to the bag.

    Raises:
        SetcmasError: The bag cannot be read, or the files cannot be written.
    """
    folder = output or _default_output(bag)
    with open_bag(bag) as source, file_errors(f"CSV files cannot be written to '{folder}'"):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix='.converting-', dir=folder) as unfinished:
            return _write_files(source, Path(unfinished), folder)


def _default_output(bag: Path) -> Path:
    resolved = bag.resolve()
    if resolved.is_dir() and (resolved / 'bag').is_dir():
        resolved /= 'bag'
    found, here = resolved.parent / f'{stem_of_bag(resolved)}csv', Path.cwd()
    return found if bag.is_absolute() or here not in found.parents else found.relative_to(here)


def _write_files(bag: Bag, unfinished: Path, folder: Path) -> ConversionReport:
    names = file_names(topic.name for topic in bag.topics)
    samples = RunSamples(bag.topics)
    rows = {
        topic: TopicTable(
            unfinished / name,
            bag.types,
            skip_repeated=topic.name.endswith(f'/{TRIG_ODOM}'),  # it repeats the last state sent
        )
        for topic, name in zip(bag.topics, names, strict=True)
    }
    takers = {topic: [own.add, *samples.collectors(topic)] for topic, own in rows.items()}
    bag.deliver(takers, bag.first_command())
    written = [own for own in rows.values() if own.nb_rows]
    if not written:
        raise SetcmasError(f"bag '{bag.path}' cannot be read: {bag.notices[-1]}")
    for own in written:
        own.finish()
    if tables := samples.tables():
        write_tables(tables, unfinished)
    for path in sorted(unfinished.iterdir()):
        path.replace(folder / path.name)
    return ConversionReport(
        folder,
        [folder / own.path.name for own in written],
        folder / FLEET.name if tables else None,
        sum(own.nb_rows for own in written),
        (bag.end_ns - bag.start_ns) / 1e9,
        bag.notices + samples.notices,
    )


def file_names(topics: Iterable[str]) -> list[str]:
    """Return a file name for each topic, such as tb3_1_odom.csv for /tb3_1/odom.

    Names that would be equal get a number, also those that differ in upper and lower case only.
    """
    taken = set(FILE_NAMES)
    names = []
    for topic in topics:
        stem = re.sub(r'[^A-Za-z0-9_.-]', '_', topic.strip('/')) or 'topic'
        candidates = chain([f'{stem}.csv'], (f'{stem}_{number}.csv' for number in count(2)))
        names.append(next(name for name in candidates if name.lower() not in taken))
        taken.add(names[-1].lower())
    return names
