from pathlib import Path

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Obstacles, ObstaclesKind
from setcmas_simu.yaml_entries import entries_of

TEXT = 'disc 1 2 0.5; polygon 0 0 1 0 1 1.5'


def listed(text):
    """Return the obstacles of a list in a YAML file."""
    return ObstaclesKind().read(entries_of(text, Path('walls.yaml')), str)


def test_a_list_says_the_same_as_a_text():
    shapes = '- polygon: [[0, 0], [1, 0], [1, 1.5]]\n- disc: [1, 2, 0.5]\n'

    assert listed(shapes) == TEXT == str(Obstacles.of(TEXT))


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('disc 1 2 3 4', 'must be a disc'),
        ('disc 1 2 -1', 'radius above 0'),
        ('disc 1 nan 1', 'finite'),
        ('circle 1 2 3', 'invalid obstacle'),
        ('disc 0 2', 'has no radius'),
        ('polygon 0 0 1 0 1 1 0 0', 'has the same corner twice'),
        (
            'polygon 0 0 1 1 1 0 0 1',
            r'\(0, 0\) to \(1, 1\) crosses or touches that from \(1, 0',
        ),
        ('polygon 0 0 2 2 2 0 1 1 0 2', 'crosses or touches'),  # at a corner
        ('polygon 0 0 2 0 1 0 1 1', 'crosses or touches'),  # back on the same line
    ],
)
def test_a_mistake_is_named(text, message):
    with pytest.raises(SetcmasError, match=message):
        Obstacles.of(text)


@pytest.mark.parametrize(
    'text',
    [
        'polygon 0 0 1 0 2 0 2 2 0 2',  # a corner in the middle of a straight wall
        'polygon 0 0 3 0 3 3 2 3 2 1 1 1 1 3 0 3',  # a U
        'polygon 0 0 0 2 2 2 1 1',  # clockwise
    ],
)
def test_a_polygon_need_not_be_convex(text):
    assert str(Obstacles.of(text)) == text


def test_a_mistake_in_a_list_is_reported_with_its_line():
    with pytest.raises(SetcmasError, match=r'walls.yaml, line 2: .*at least 3 corners'):
        listed('- disc: [1, 2, 0.5]\n- polygon: [[0, 0], [1, 1]]\n')
