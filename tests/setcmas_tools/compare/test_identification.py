import numpy as np
import pytest

from setcmas_simu.robots.identified_robot import Response
from setcmas_tools.compare.identification import (
    FORWARD,
    TURN,
    Channel,
    Identified,
    identified_notes,
)
from setcmas_tools.compare.response_fit import Fit, HeldCommand, Measured


def identified(forward_quality):
    nothing = Measured(HeldCommand(np.zeros(1), np.zeros(1)), *[np.zeros(1)] * 3, 1.0)
    response, errors = Response(0.92, 0.1, 0.2), Response(0.01, 0.01, 0.01)
    channels = {
        speed: Channel(Fit(response, errors, quality), 'poses', 0.0, nothing)
        for speed, quality in ((FORWARD, forward_quality), (TURN, 95.0))
    }
    return {1: Identified(channels, {FORWARD: response, TURN: response}, 0.0)}


def test_a_poor_fit_is_reported_though_its_standard_errors_are_small():
    (note,) = identified_notes(identified(44.0))

    assert note.startswith('tb3_1: the model explains less than 70 % of its forward speed;')


@pytest.mark.parametrize('quality', [75.0, 100.0])
def test_a_good_fit_needs_no_word(quality):
    assert not [*identified_notes(identified(quality))]
