from pathlib import Path

import pytest
import yaml

from setcmas_simu.fleet.palettes import colour
from setcmas_simu.fleet.rviz_config import rviz_config

ROOT = Path(__file__).parents[3]
PLUGINS = ('Grid', 'Axes', 'Pose', 'Odometry', 'Marker', 'MarkerArray')
CLASSES = {'rviz_common/Group', *(f'rviz_default_plugins/{name}' for name in PLUGINS)}
TOPIC_KEYS = {
    'Depth', 'Durability Policy', 'Filter size', 'History Policy', 'Reliability Policy', 'Value',
}  # fmt: skip


def displays(config):
    """Return all displays of a parsed configuration, those in groups too."""
    found, waiting = [], list(config['Visualization Manager']['Displays'])
    while waiting:
        display = waiting.pop()
        found.append(display)
        waiting += display.get('Displays', [])
    return found


def topics_of(text):
    return {d['Topic']['Value']: d for d in displays(yaml.safe_load(text)) if 'Topic' in d}


@pytest.mark.parametrize('experiment', [False, True])
def test_classes_and_keys_are_those_of_rviz_2(experiment):
    config = yaml.safe_load(rviz_config([1, 2], experiment))

    assert [panel['Class'] for panel in config['Panels']] == ['rviz_common/Displays']
    assert config['Visualization Manager']['Global Options']['Fixed Frame'] == 'world'
    assert {display['Class'] for display in displays(config)} <= CLASSES
    for display in displays(config):
        kind = display['Class'].rpartition('/')[2]
        if 'Topic' in display:
            lacking = {'Filter size'} if kind == 'MarkerArray' else set()
            assert set(display['Topic']) == TOPIC_KEYS - lacking
        if kind.startswith('Marker'):
            assert display['Namespaces'] == {}
        if kind == 'Odometry':
            assert {'Position Tolerance', 'Angle Tolerance', 'Keep', 'Shape'} <= set(display)
            assert display['Covariance'] == {'Value': False}


@pytest.mark.parametrize('robot', [1, 4, 9])
def test_arrows_have_the_colour_of_their_robot(robot):
    shown = topics_of(rviz_config([robot]))

    for display in (shown[f'/tb3_{robot}/pose'], shown[f'/tb3_{robot}/odom']['Shape']):
        channels = [int(channel) / 255 for channel in display['Color'].split('; ')]
        assert channels == pytest.approx(colour(robot), abs=0.01)
