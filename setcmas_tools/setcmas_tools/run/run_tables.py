"""Tables of a run, and the folder of CSV files that holds them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from setcmas_ctrl.control.references import References
from setcmas_simu.errors import SetcmasError
from setcmas_tools.run import communication_record, drawing_record, fleet_motion, law_commands
from setcmas_tools.run.communication_record import CommunicationRecord
from setcmas_tools.run.drawing_record import Drawing
from setcmas_tools.run.fleet_motion import FleetTable
from setcmas_tools.run.law_commands import Commands, SafetyRecord

TASK_FILE = 'task.json'
FILE_NAMES = (
    fleet_motion.FLEET_FILE,
    law_commands.COMMANDS_FILE,
    drawing_record.DRAWINGS_FILE,
    law_commands.SAFETY_FILE,
    *communication_record.COMMUNICATION_FILES,
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
    fleet_motion.write_fleet(tables.fleet, folder / fleet_motion.FLEET_FILE)
    if tables.commands:
        law_commands.write_commands(tables.commands, folder / law_commands.COMMANDS_FILE)
    if tables.communication:
        communication_record.write_communication(tables.communication, folder)
    if tables.drawings:
        drawing_record.write_drawings(tables.drawings, folder / drawing_record.DRAWINGS_FILE)
    if tables.safety:
        law_commands.write_safety(tables.safety, folder / law_commands.SAFETY_FILE)
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
        fleet_motion.read_fleet(fleet_csv),
        law_commands.read_commands(folder / law_commands.COMMANDS_FILE),
        communication_record.read_communication(folder),
        drawing_record.read_drawings(folder / drawing_record.DRAWINGS_FILE),
        _read_references(folder / TASK_FILE),
        law_commands.read_safety(folder / law_commands.SAFETY_FILE),
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
