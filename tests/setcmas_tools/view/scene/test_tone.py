import numpy as np
import pytest

from setcmas_simu.fleet import fleet
from setcmas_tools.view.scene.tone import tone_mapped, untoned


def test_what_the_client_makes_of_full_colours():
    # Read from a screenshot of viser 1.1.1: lines in green, yellow and salmon, uncorrected.
    given = [fleet.colour(2), fleet.colour(4), fleet.colour(7)]
    seen = [(147, 228, 89), (227, 223, 182), (229, 197, 183)]

    np.testing.assert_allclose(255 * tone_mapped(given), seen, atol=1.5)


@pytest.mark.parametrize('colour', [(0.5, 0.5, 0.5), (0.4, 0.3, 0.2), (0.0, 0.0, 0.0)])
def test_muted_colours_come_out_in_their_hue(colour):
    shown = tone_mapped(untoned(colour))

    np.testing.assert_allclose(
        shown, np.array(colour) * shown.max() / max(*colour, 1e-9), atol=0.03
    )


def test_the_colours_of_the_robots_stay_apart():
    shown = tone_mapped(untoned([fleet.colour(robot) for robot in range(1, 10)]))
    distances = np.linalg.norm(shown[:, None] - shown[None], axis=2) + 9 * np.eye(9)

    assert distances.min() > 0.25
