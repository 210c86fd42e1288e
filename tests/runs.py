"""Runs from tables and folders, measured, plotted and filmed as the commands do it."""

import numpy as np

from setcmas_tools.measures.metrics import measure as measure_run
from setcmas_tools.plots import film
from setcmas_tools.plots.plot import plot as plot_run
from setcmas_tools.plots.plot_settings import FilmSettings, PlotSettings
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_folder import find_run
from setcmas_tools.run.run_info import RunInfo
from setcmas_tools.run.run_tables import RunTables


def run_of(table, record=None, references=None, **parameters):
    tables = RunTables(table, communication=record, references=references)
    return Run(tables, RunInfo(scenario=parameters))


def measure(table, record=None, references=None, **parameters):
    return measure_run(run_of(table, record, references, **parameters))


def plot(path, output=None, **look):
    return plot_run(Run.load(path), output or find_run(path).plots, PlotSettings(**look))


def animate(path, output=None, kind=None, **look):
    return film.animate(Run.load(path), output or find_run(path).plots, kind, FilmSettings(**look))


def distance(run, table, largest_shift=0.5):
    """Return how far (m, RMS per robot) recorded robots are from a simulated run.

    That is after the shift in time, up to the largest (s), at which they are nearest.
    """
    tracks = [table.of(robot) for robot in table.robots]

    def rms(shift):
        t = run.t[(run.t + shift >= table.t[0]) & (run.t + shift <= table.t[-1])]
        paths = [(np.interp(t + shift, p.t, p.x), np.interp(t + shift, p.t, p.y)) for p in tracks]
        apart = np.array(paths) - run.poses[np.isin(run.t, t), :2].transpose(2, 1, 0)
        return np.sqrt(np.mean(np.sum(apart**2, axis=1)))

    return min(rms(shift) for shift in np.linspace(-largest_shift, largest_shift, 101))
