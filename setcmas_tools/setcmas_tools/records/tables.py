"""Tables of a run, and the folder of CSV files that holds them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from setcmas_ctrl.control.references import References
from setcmas_simu.errors import SetcmasError
from setcmas_tools.records import commands, communication, drawings, fleet_table, safety
from setcmas_tools.records.commands import Commands
from setcmas_tools.records.communication import CommunicationRecord
from setcmas_tools.records.drawings import Drawing
from setcmas_tools.records.fleet_table import FleetTable
from setcmas_tools.records.safety import SafetyRecord

TASK_FILE = 'task.json'
FILE_NAMES = (
    fleet_table.FILE_NAME,
    commands.FILE_NAME,
    drawings.FILE_NAME,
    safety.FILE_NAME,
    *communication.FILE_NAMES,
    TASK_FILE,
)


@dataclass(frozen=True)
class RunTables:
    """What happened in a run.

    Attributes:
        fleet: The motion of the robots.
        commands: What the laws asked for, if that is known.
        communication: What went over the links, if that is known.
        drawings: What the scripts drew, sorted by time.
        references: The task of the law, if it tells of one.
        safety: What the safety of an experiment let robots do; None if it was none.
    """

    fleet: FleetTable
    commands: Commands | None = None
    communication: CommunicationRecord | None = None
    drawings: list[Drawing] = field(default_factory=list)
    references: References | None = None
    safety: SafetyRecord | None = None


def write_tables(tables: RunTables, folder: Path) -> None:
    """Write the files of tables that there are; equal tables give equal files.

    Times have 6 decimals; poses and velocities have 9, drawings 9 significant digits.

    Raises:
        OSError: A file cannot be written.
    """
    fleet_table.write_csv(tables.fleet, folder / fleet_table.FILE_NAME)
    if tables.commands:
        commands.write_csv(tables.commands, folder / commands.FILE_NAME)
    if tables.communication:
        communication.write_csv(tables.communication, folder)
    if tables.drawings:
        drawings.write_csv(tables.drawings, folder / drawings.FILE_NAME)
    if tables.safety:
        safety.write_csv(tables.safety, folder / safety.FILE_NAME)
    if tables.references:
        text = f'{tables.references.encoded()}\n'
        (folder / TASK_FILE).write_text(text, encoding='utf-8', newline='\n')


def read_tables(fleet_csv: Path) -> RunTables:
    """Read a fleet.csv and the tables beside it.

    Raises:
        SetcmasError: A file cannot be read or is damaged.
    """
    folder = fleet_csv.parent
    return RunTables(
        fleet_table.read_csv(fleet_csv),
        commands.read_csv(folder / commands.FILE_NAME),
        communication.read_csv(folder),
        drawings.read_csv(folder / drawings.FILE_NAME),
        _read_references(folder / TASK_FILE),
        safety.read_csv(folder / safety.FILE_NAME),
    )


def _read_references(path: Path) -> References | None:
    try:
        return References.decoded(path.read_text(encoding='utf-8'))
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise SetcmasError(
            f"'{path}' is damaged; it must hold a task and its references: {error}"
        ) from error
