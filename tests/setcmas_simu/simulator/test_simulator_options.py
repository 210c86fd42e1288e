import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.simulator.simulator_options import SimulationOptions


@pytest.mark.parametrize(
    ('given', 'message'),
    [
        ({'rtf': 2.0}, 'lockstep runs as fast as possible; remove rtf'),
        ({'cmd_vel_type': 'twist'}, 'lockstep needs commands with a stamp: cmd_vel_type must be'),
        ({'nb_robots': 4, 'robots': (1, 2)}, 'lockstep needs the whole fleet in one simulator'),
    ],
)
def test_what_lockstep_does_not_go_with_is_refused(given, message):
    with pytest.raises(SetcmasError, match=message):
        SimulationOptions(lockstep=True, **given)
