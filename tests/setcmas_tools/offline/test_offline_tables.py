import numpy as np

from setcmas_tools.offline.offline_tables import remains
from setcmas_tools.run.run_info import Outcome, State


def test_nothing_remains_of_a_run_that_ended_before_its_first_state():
    run = remains(np.empty((0, 0, 0)), 10.0, Outcome(State.DIED))

    assert len(run.table.t) == 0
    assert run.outcome.state is State.DIED
