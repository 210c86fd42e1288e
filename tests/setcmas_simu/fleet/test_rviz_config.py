import re

import pytest
import yaml

from setcmas_simu.fleet.palettes import colour
from setcmas_simu.fleet.rviz_config import rviz_config


@pytest.mark.parametrize('robot', [1, 9])
def test_arrows_have_the_colour_of_their_robot(robot):
    *_, group = yaml.safe_load(rviz_config([robot]))['Visualization Manager']['Displays']
    _, pose, trail, *_ = group['Displays']

    for display in (pose, trail['Shape']):
        channels = [int(channel) / 255 for channel in display['Color'].split('; ')]
        assert channels == pytest.approx(colour(robot), abs=0.01)


def test_displays_are_those_of_rviz_2():
    shown = set(re.findall(r'Class: rviz_default_plugins/(.*)', rviz_config([1, 2], True)))
    assert shown == {'Grid', 'Axes', 'Odometry', 'Marker', 'MarkerArray'}
