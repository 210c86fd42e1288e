"""Runs from tables and folders, measured, plotted and filmed as the commands do it."""

import numpy as np

from setcmas_tools.films import film
from setcmas_tools.metrics.compute import measure as measure_run
from setcmas_tools.plots.looks.look import FilmLook, PlotLook
from setcmas_tools.plots.plot import plot as plot_run
from setcmas_tools.records.tables import RunTables
from setcmas_tools.run.info import RunInfo
from setcmas_tools.run.run import Run
from setcmas_tools.run.source import find_run


def run_of(table, record=None, references=None, **parameters):
    tables = RunTables(table, communication=record, references=references)
    return Run(tables, RunInfo(parameters=parameters))


def measure(table, record=None, references=None, call_times=None, **parameters):
    run = run_of(table, record, references, **parameters)
    times = None if call_times is None else np.array(call_times)
    return measure_run(Run(run.tables, run.info, call_time=times))


def plot(path, output=None, **look):
    return plot_run(Run.load(path), output or find_run(path).plots, PlotLook(**look))


def animate(path, output=None, kind=None, **look):
    return film.animate(Run.load(path), output or find_run(path).plots, kind, FilmLook(**look))
