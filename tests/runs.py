"""Runs from tables and folders, measured, plotted and filmed as the commands do it."""

from setcmas_tools.measures.metrics import measure as measure_run
from setcmas_tools.plots import film
from setcmas_tools.plots.plot import plot as plot_run
from setcmas_tools.plots.plot_options import PlotOptions
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import find_run
from setcmas_tools.run.run_info import RunInfo


def run_of(table, record=None, references=None, **parameters):
    info = RunInfo(scenario=parameters)
    return Run(table, record=record, references=references, info=info)


def measure(table, record=None, references=None, **parameters):
    return measure_run(run_of(table, record, references, **parameters))


def plot(path, output=None, **look):
    return plot_run(Run.load(path), output or find_run(path).plots, PlotOptions(**look))


def animate(path, output=None, kind=None, **look):
    return film.animate(Run.load(path), output or find_run(path).plots, kind, **look)
