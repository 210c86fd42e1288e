"""An experiment against its simulation, of two runs that are that."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from setcmas_simu.errors import SetcmasError
from setcmas_tools.comparison.verdict import Verdict, is_experiment, verdicts
from setcmas_tools.comparison.verdict_table import told, unknown, verdict_table
from setcmas_tools.identification.drive import drives
from setcmas_tools.run.run import Run


@dataclass(frozen=True)
class ExperimentVerdict:
    """How an experiment and its simulation go together.

    Attributes:
        title: Which is which.
        found: The verdict on each robot, by its number.
        hint: What would bring the simulation nearer; nothing if it is near, or nothing is known.
    """

    title: str
    found: Mapping[int, Verdict]
    hint: str = ''

    def table(self, form: str = 'simple') -> str:
        """Return a row for each robot, in a format of tabulate."""
        return verdict_table(self.found, form)

    @property
    def lines(self) -> list[str]:
        """What the table says in words, and what is not known."""
        lines = [*told(self.found), *(f'- in {line}' for line in unknown(self.found))]
        return [*lines, self.hint] if self.hint else lines


def experiment_verdict(
    paths: Sequence[Path], runs: Sequence[Run], warn: Callable[[str], None]
) -> ExperimentVerdict | None:
    """Return how two runs go together; None if they are no experiment and its simulation.

    Args:
        paths: Where the two runs are: commands are read from their bags.
        runs: The two runs.
        warn: Shows what could not be read.
    """
    both = zip(paths, runs, strict=True)
    (simulated, simulation), (path, experiment) = sorted(
        both, key=lambda one: is_experiment(one[1])
    )
    if is_experiment(simulation) or not is_experiment(experiment):
        return None
    try:
        commanded = drives(path, warn)
    except SetcmasError:
        commanded = {}
    title = f'experiment {path} against simulation {simulated}'
    found = verdicts(simulation, experiment, commanded)
    hint = ''
    if commanded and any(one.parted is not None for one in found.values()):
        hint = (
            f'setcmas identify {path} finds a model of these robots, for simulations nearer to it'
        )
    return ExperimentVerdict(title, found, hint)
