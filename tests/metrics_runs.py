"""Runs that are measured in tests."""

import numpy as np

from setcmas_tools.measures.metrics import measure
from setcmas_tools.run.fleet_motion import fleet_table
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import RunInfo, write_info
from setcmas_tools.run.run_tables import RunTables, write_tables

T = np.arange(0, 201) / 10
"""0 to 20 s at 10 Hz."""


def table(*robots):
    """A table of robots, each given as (times, x, y) or (times, x, y, v)."""
    rows = []
    for number, (t, x, y, *v) in enumerate(robots, start=1):
        columns = np.broadcast_arrays(t, number, x, y, 0.0, v[0] if v else 0.0, 0.0)
        rows += np.transpose(columns).tolist()
    return fleet_table(rows)


def numbers(value):
    if isinstance(value, dict):
        return [number for item in value.values() for number in numbers(item)]
    if isinstance(value, list):
        return [number for item in value for number in numbers(item)]
    return [value] if isinstance(value, float) else []


def write_run(folder, fleet, lab=None, **parameters):
    (folder / 'csv').mkdir(parents=True)
    write_tables(RunTables(fleet), folder / 'csv')
    write_info(RunInfo(scenario=parameters, lab=lab), folder)
    return folder


def compute(path, **options):
    return measure(Run.load(path), **options)
