"""Conversion of a bag to a CSV file for each topic, and the tables of its run."""

from __future__ import annotations

import re
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.bag import Bag, BagTopic, open_bag
from setcmas_tools.bags.message_types import UndecodableError
from setcmas_tools.bags.topic_table import CsvTable, flattener
from setcmas_tools.run.csv_columns import FLEET
from setcmas_tools.run.run_folder import stem_of_bag
from setcmas_tools.run.run_samples import Collect, RunSamples
from setcmas_tools.run.run_tables import FILE_NAMES, write_tables

_LONG_BAG = 50_000
"""Messages from which a progress bar is worth a look: about 2 s."""


@dataclass(frozen=True)
class ConversionReport:
    """What a conversion has written; as text, the lines to show to the user.

    Attributes:
        folder: Where the files are.
        files: One CSV file for each topic, sorted by topic.
        fleet: The fleet's table; None if the bag has no odometry of the fleet.
        messages: How many rows all topics have together.
        duration: From the first to the last message, in s.
        notices: A line for each thing in the bag that could not be read.
    """

    folder: Path
    files: list[Path]
    fleet: Path | None
    messages: int
    duration: float
    notices: list[str]

    def __str__(self) -> str:
        """Return the notices and a summary."""
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

    Files of these names that are there already are replaced, all of them at the end only.

    Args:
        bag: What `bag_reader.open_bag` accepts.
        output: Folder of the files; by default `csv` beside a bag folder that is named `bag`,
            else `<name of the bag>_csv` beside the bag.

    Raises:
        SetcmasError: The bag cannot be read, or the files cannot be written.
    """
    folder = output or _default_output(bag)
    with open_bag(bag) as source:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix='.converting-', dir=folder) as unfinished:
                report = _write_files(source, Path(unfinished), folder)
        except OSError as error:
            raise SetcmasError(
                f"CSV files cannot be written to '{folder}': {error.strerror}"
            ) from error
    return report


def _default_output(bag: Path) -> Path:
    resolved = bag.resolve()
    if resolved.is_dir() and (resolved / 'bag').is_dir():
        resolved /= 'bag'
    return _as_given(resolved.parent / f'{stem_of_bag(resolved)}csv', bag)


def _as_given(path: Path, like: Path) -> Path:
    """Return a path relative to the current folder if the user's one is."""
    here = Path.cwd()
    return path.relative_to(here) if not like.is_absolute() and here in path.parents else path


def _write_files(bag: Bag, unfinished: Path, folder: Path) -> ConversionReport:
    topics = [topic for topic in bag.topics if not topic.derived]
    names = file_names(topic.name for topic in topics)
    samples = RunSamples((topic.name, topic.type.name) for topic in topics)
    jobs = {
        topic: _TopicJob(topic, unfinished / name, samples.collectors(topic.name, topic.type.name))
        for topic, name in zip(topics, names, strict=True)
    }
    for topic, time_ns, data in _with_progress(bag):
        if job := jobs.get(topic):
            job.take(time_ns - bag.start_ns, data)
    written = [job for job in jobs.values() if job.finish()]
    if tables := samples.tables():
        write_tables(tables, unfinished)
    for file in sorted(unfinished.iterdir()):
        file.replace(folder / file.name)
    return ConversionReport(
        folder,
        [folder / job.path.name for job in written],
        folder / FLEET.name if tables else None,
        sum(job.nb_rows for job in written),
        (bag.end_ns - bag.start_ns) / 1e9,
        bag.notices + [job.notice for job in jobs.values() if job.notice],
    )


class _TopicJob:
    """What happens to the messages of one topic."""

    def __init__(self, topic: BagTopic, path: Path, collect: list[Collect]) -> None:
        self.topic = topic
        self.path = path
        self.nb_rows = 0
        self.notice = ''
        self._collect = collect
        self._decode = topic.type.decode
        self._table = CsvTable(path, flattener(topic.type.store, topic.type.name))
        self._nb_undecodable = 0

    def take(self, time_ns: int, data: bytes) -> None:
        try:
            message = self._decode(data)
        except UndecodableError as error:
            self._nb_undecodable += 1
            self.notice = (
                f'topic {self.topic.name}: {self._nb_undecodable:,} of {self.topic.count:,} '
                f'messages are left out, their bytes are not a {self.topic.type.name} ({error})'
            )
            return
        self._table.add(time_ns, message)
        self.nb_rows += 1
        for collect in self._collect:
            collect(time_ns, message)

    def finish(self) -> bool:
        if self.nb_rows:
            self._table.finish()
        return self.nb_rows > 0


def file_names(topics: Iterable[str]) -> list[str]:
    """Return a file name for each topic, such as tb3_1_odom.csv for /tb3_1/odom.

    The names differ even where upper and lower case are the same, as on Windows; those that
    would not get a number.
    """
    taken: Counter[str] = Counter(FILE_NAMES)
    names = []
    for topic in topics:
        stem = re.sub(r'[^A-Za-z0-9_.-]', '_', topic.strip('/')) or 'topic'
        name = f'{stem}.csv'
        number = 2
        while taken[name.lower()]:
            name = f'{stem}_{number}.csv'
            number += 1
        taken[name.lower()] += 1
        names.append(name)
    return names


def _with_progress(bag: Bag) -> Iterator[tuple[BagTopic, int, bytes]]:
    if bag.count < _LONG_BAG or not sys.stderr.isatty():
        return bag.messages()
    from tqdm import tqdm  # only the long bags pay for its import

    return iter(tqdm(bag.messages(), total=bag.count, unit=' messages', unit_scale=True))
