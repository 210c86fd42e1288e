"""Where the files of a run are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.errors import SetcmasError
from setcmas_tools.records import fleet_table

INPUTS = 'inputs'
"""The folder of a run with copies of the files that it was given, in a folder for each option."""


def fleet_csv(run: Path) -> Path:
    """Return the fleet's table of a run.

    Args:
        run: The folder of a run, the folder of its CSV files, or a fleet.csv.

    Raises:
        SetcmasError: There is none.
    """
    if run.is_file():
        return run
    places = [run / 'csv' / fleet_table.FILE_NAME, run / fleet_table.FILE_NAME]
    for place in places:
        if place.is_file():
            return place
    if not run.exists():
        raise SetcmasError(f"there is no '{run}'; accepted are the folder of a run, a fleet.csv")
    hint = '; make it with bag_to_csv' if (run / 'bag').is_dir() else ''
    raise SetcmasError(f"there is no fleet.csv in '{run}' or in its folder csv{hint}")


def run_folder(source: Path) -> Path:
    """Return the folder of the run that a fleet.csv belongs to: above `csv`, else its own."""
    is_csv_folder = source.resolve().parent.name == 'csv'
    return source.parent.parent if is_csv_folder else source.parent


def kept_input(source: Path, option: str, name: str) -> Path | None:
    """Return the copy of a file that the run of a fleet.csv was given; None if it has none."""
    path = run_folder(source) / INPUTS / option / name
    return path if path.is_file() else None


def run_parameters(source: Path) -> dict[str, Any]:
    """Return the parameters in the run.yaml of a fleet.csv; empty if there is none.

    Raises:
        SetcmasError: The file cannot be read or is damaged.
    """
    record = run_folder(source) / 'run.yaml'
    try:
        content = yaml.safe_load(record.read_text(encoding='utf-8'))
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = ' '.join(str(error).split())
        raise SetcmasError(f"'{record}' cannot be read: {reason}") from error
    parameters = content.get('parameters') if isinstance(content, dict) else None
    if not isinstance(parameters, dict):
        raise SetcmasError(f"'{record}' is no record of a run: it has no parameters")
    return parameters
