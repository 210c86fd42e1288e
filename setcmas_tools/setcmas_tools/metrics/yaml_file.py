"""The file metrics.yaml: the metrics of a run, the same bytes for equal runs."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import yaml

from setcmas_simu.errors import SetcmasError
from setcmas_tools.metrics.compute import Metrics
from setcmas_tools.records import fleet_table
from setcmas_tools.run.files import run_folder

FILE_NAME = 'metrics.yaml'

_DIGITS = 6


class _Dumper(yaml.SafeDumper):
    """Writes lists in one line."""

    def represent_list(self, data: Any) -> yaml.SequenceNode:
        return self.represent_sequence('tag:yaml.org,2002:seq', data, flow_style=True)


_Dumper.add_representer(list, _Dumper.represent_list)


def metrics_file(source: Path) -> Path:
    """Return where the metrics of a fleet's table go: into the folder of its run.

    A table of another name than fleet.csv has that name before the file's.
    """
    stem = '' if source.name == fleet_table.FILE_NAME else f'{source.stem}_'
    return run_folder(source) / f'{stem}{FILE_NAME}'


def as_dict(metrics: Metrics) -> dict[str, Any]:
    """Return metrics as plain values in a fixed order, rounded, without parts that are None.

    Times per call are left out: they differ between equal runs.
    """
    parts = {name: value for name, value in asdict(metrics).items() if value is not None}
    parts.pop('mean_call_time_s', None)
    communications = parts.pop('communications')
    for robot, motion in parts['robots'].items():
        motion['communications'] = communications[robot]
    return {name: _rounded(value) for name, value in parts.items()}


def write_yaml(metrics: Metrics, path: Path) -> None:
    """Write metrics with 6 significant digits.

    Raises:
        SetcmasError: The file cannot be written.
    """
    text = yaml.dump(as_dict(metrics), Dumper=_Dumper, sort_keys=False, width=98)
    try:
        path.write_text(text, encoding='utf-8', newline='\n')
    except OSError as error:
        raise SetcmasError(f"'{path}' cannot be written: {error.strerror}") from error


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    if isinstance(value, float):
        return float(f'{value:.{_DIGITS}g}') + 0.0  # + 0.0: no minus before zero
    return value
