import math

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.simulation_options import SimulationOptions


@pytest.mark.parametrize('value', [0.0, 0.3, 1.0, math.inf])
def test_a_command_timeout_is_never_or_longer_than_between_two_commands(value):
    assert SimulationOptions(cmd_timeout=value).cmd_timeout == value


@pytest.mark.parametrize('value', [0.2, -1.0, math.nan])
def test_shorter_command_timeouts_are_refused(value):
    with pytest.raises(SetcmasError, match=r'it must be at least 0\.3 s, or 0 for never'):
        SimulationOptions(cmd_timeout=value)
