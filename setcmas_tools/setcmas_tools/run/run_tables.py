"""Tables of a run, and the folder of CSV files that holds them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from setcmas_ctrl.communication.message_content import checked_value, plain
from setcmas_ctrl.laws.drawing import Sphere
from setcmas_ctrl.laws.references import References
from setcmas_simu.errors import SetcmasError
from setcmas_simu.limited_file import read_limited, written_whole
from setcmas_tools.run.csv_columns import (
    ALL,
    COMMANDS,
    COUNTS,
    CSV_FILES,
    DRAWINGS,
    FLEET,
    GRAPH,
    MESSAGES,
    SAFETY,
    TRIGGERS,
)
from setcmas_tools.run.fleet_motion import FleetTable, check_extent, fleet_table
from setcmas_tools.run.run_records import (
    Commands,
    CommunicationRecord,
    Counts,
    Drawing,
    SafetyRecord,
    SentMessage,
    commands,
    safety_record,
)

TASK_FILE = 'task.json'
_MOST_TASK_BYTES = 10_000_000
FILE_NAMES = (*(file.name for file in CSV_FILES), TASK_FILE)


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


@dataclass(frozen=True, eq=False)
class RunTables:
    """What happened in a run.

    Attributes:
        table: The motion of the robots: a row for each state of each robot, as in fleet.csv.
        commands: Velocities that the laws returned, after saturation, if known.
        record: Messages of each link; None if unknown, or if all robots knew all poses.
        drawings: The drawings of the scripts, sorted by time.
        references: The task of the law and its references, if it has one.
        safety: The states of the robots of an experiment; None of a simulation.
        messages: The values that the laws sent with `network.send`, sorted by time, then robot.
    """

    table: FleetTable
    commands: Commands | None = None
    record: CommunicationRecord | None = None
    drawings: list[Drawing] = field(default_factory=list)
    references: References | None = None
    safety: SafetyRecord | None = None
    messages: list[SentMessage] = field(default_factory=list)


def write_tables(tables: RunTables, folder: Path) -> None:
    """Write a file for each table of a run; equal tables give equal files.

    Raises:
        OSError: A file cannot be written.
    """
    write_fleet(tables.table, folder / FLEET.name)
    if given := tables.commands:
        columns = [given.t, given.robot, given.vx, given.vy]
        if allowed := given.allowed:
            columns += [allowed.vx, allowed.vy, allowed.verdict]
        COMMANDS.write(folder / COMMANDS.name, _rows(*columns), further=allowed is not None)
    if tables.record:
        write_communication(tables.record, folder)
    if tables.drawings:
        DRAWINGS.write(folder / DRAWINGS.name, map(_drawing_row, tables.drawings))
    if safety := tables.safety:
        rows = _rows(safety.t, safety.robot, np.array(safety.state, object), safety.overruled)
        SAFETY.write(folder / SAFETY.name, rows)
    if tables.messages:
        MESSAGES.write(folder / MESSAGES.name, map(_message_row, tables.messages))
    if tables.references:
        with written_whole(folder / TASK_FILE) as file:
            file.write(f'{tables.references.encoded()}\n')


def read_tables(fleet_csv: Path) -> RunTables:
    """Read a fleet.csv and the other tables in its folder, or raise SetcmasError."""
    folder = fleet_csv.parent
    rows = COMMANDS.read(folder / COMMANDS.name)
    safety = SAFETY.read(folder / SAFETY.name)
    return RunTables(
        read_fleet(fleet_csv),
        None if rows is None else commands(np.column_stack(rows)),
        read_communication(folder),
        [_drawing(*row) for row in _rows(*(DRAWINGS.read(folder / DRAWINGS.name) or ()))],
        _read_references(folder / TASK_FILE),
        None if safety is None else safety_record([*_rows(*safety)]),
        _read_messages(folder / MESSAGES.name),
    )


def _rows(*columns: Any) -> Iterator[Any]:
    """Return the rows of columns that are arrays."""
    return zip(*(column.tolist() for column in columns), strict=True)


def write_fleet(table: FleetTable, path: Path) -> None:
    """Write the motion of a fleet; an OSError is raised if this fails."""
    FLEET.write(path, _rows(*(getattr(table, column.name) for column in FLEET.columns)))


def read_fleet(path: Path) -> FleetTable:
    """Read the motion of a fleet, or raise SetcmasError."""
    columns = FLEET.read(path)
    if columns is None:
        raise SetcmasError(f"'{path}' cannot be read: there is no such file")
    if not len(columns[0]):
        raise SetcmasError(f"'{path}' holds no rows; it must have the columns {FLEET.header}")
    table = fleet_table(np.column_stack(columns))
    check_extent(table, path)
    return table


def _drawing_row(drawing: Drawing) -> tuple[Any, ...]:
    x, y, z, diameter, colour, alpha = drawing.sphere
    return (*drawing[:4], x, y, z, diameter, *colour, alpha)


def _drawing(t: float, robot: float, name: str, kind: str, *numbers: float) -> Drawing:
    x, y, z, diameter, red, green, blue, alpha = numbers
    sphere = Sphere(x, y, z, diameter, (red, green, blue), alpha)
    return Drawing(t, int(robot), name, kind, sphere)


def _message_row(message: SentMessage) -> tuple[Any, ...]:
    text = json.dumps(plain(message.value)).replace('"', '""')
    return message.t, message.robot, f'"{text}"'


def _read_messages(path: Path) -> list[SentMessage]:
    """Read the messages of a run, or raise SetcmasError."""
    messages = []
    for t, robot, text in _rows(*(MESSAGES.read(path) or ())):
        try:
            messages.append(SentMessage(t, int(robot), checked_value(json.loads(text))))
        except (TypeError, ValueError, RecursionError) as error:
            raise SetcmasError(f"'{path}' is damaged at t = {t:g} s: {error}") from error
    return messages


def write_communication(record: CommunicationRecord, folder: Path) -> None:
    """Write the files of a record; an OSError is raised if this fails."""
    counts = {(robot, ALL): own for robot, own in record.robots.items()} | {
        (sender, receiver): own for (receiver, sender), own in record.links.items()
    }
    rows = (
        (*pair, own.sent, own.received, own.lost, own.mean_interval)
        for pair, own in counts.items()
    )
    COUNTS.write(folder / COUNTS.name, rows)
    if record.is_event_triggered:
        TRIGGERS.write(folder / TRIGGERS.name, record.triggers.tolist())
    GRAPH.write(folder / GRAPH.name, record.changes.tolist())


def read_communication(folder: Path) -> CommunicationRecord | None:
    """Read the record of a run from the folder of its CSV files; None if it has none.

    Raises:
        SetcmasError: A file cannot be read or is damaged.
    """
    columns = COUNTS.read(folder / COUNTS.name)
    if columns is None:
        return None
    robots: dict[int, Counts] = {}
    links: dict[tuple[int, int], Counts] = {}
    for sender, receiver, sent, received, lost, mean_interval in _rows(*columns):
        counts = Counts(int(sent), int(received), int(lost), mean_interval)
        if receiver == ALL:
            robots[int(sender)] = counts
        elif receiver.isdecimal():
            links[int(receiver), int(sender)] = counts
        else:
            raise SetcmasError(
                f"'{folder / COUNTS.name}' is damaged: '{receiver[:40]}' is not a robot"
            )
    triggers = TRIGGERS.read(folder / TRIGGERS.name) or [np.empty(0)] * len(TRIGGERS.columns)
    changes = GRAPH.read(folder / GRAPH.name) or [np.empty(0)] * len(GRAPH.columns)
    return CommunicationRecord(robots, links, np.column_stack(triggers), np.column_stack(changes))


def _read_references(path: Path) -> References | None:
    try:
        return References.decoded(read_limited(path, _MOST_TASK_BYTES).decode('utf-8'))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise SetcmasError(
            f"'{path}' is damaged; it must hold a task and its references: {error}"
        ) from error
