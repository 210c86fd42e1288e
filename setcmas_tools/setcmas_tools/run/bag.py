"""The tables of a run, read from its bag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_tools.bags.reader import open_bag
from setcmas_tools.bags.types import UndecodableError
from setcmas_tools.records.samples import RunSamples
from setcmas_tools.records.tables import RunTables


def read_bag(path: Path, warn: Callable[[str], None]) -> RunTables:
    """Return the tables of a bag.

    Args:
        path: The bag.
        warn: Shows what could not be read.

    Raises:
        SetcmasError: The bag cannot be read, or holds no odometry of robots.
    """
    with open_bag(path) as bag:
        samples = RunSamples((topic.name, topic.type.name) for topic in bag.topics)
        jobs = {topic: samples.collectors(topic.name, topic.type.name) for topic in bag.topics}
        for topic, time_ns, data in bag.messages():
            if jobs[topic]:
                try:
                    message = topic.type.decode(data)
                except UndecodableError:
                    continue  # bag_to_csv counts them
                for collect in jobs[topic]:
                    collect(time_ns - bag.start_ns, message)
        for notice in bag.notices:
            warn(notice)
    if tables := samples.tables():
        return tables
    raise SetcmasError(f"bag '{path}' holds no odometry of robots (/tb3_i/odom)")
