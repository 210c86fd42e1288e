"""Imported by the process from which runs are forked: a short run loads all that they share."""

from joblib import wrap_non_picklable_objects  # noqa: F401

from setcmas_tools.run.scenario import Scenario
from setcmas_tools.study.study import row_of

_LINKS = {'graph': 'ring', 'loss': 0.1, 'event_triggered': True}
row_of(0, (Scenario.of('consensus', nb_robots=3, duration=1.0, **_LINKS), {}))
