"""Scripts in the style of the ROS 1 stack run as they are, with ROS and without."""

from pathlib import Path

import numpy as np
import pytest

from setcmas_tools import simulate

FOLDER = Path(__file__).parent / 'ros1'
PRINTED = {
    'circle_with_tabs': '',
    'with_helper': 'tb3_{i}: first call of the helper of robot {i}\n',
    'class_and_integers': 'tb3_{i}: waypoint 1\n',
    'nested_function_and_sys': 'tb3_{i}: third call\n',
}
"""Each script, and what every robot's prints once at least."""


@pytest.mark.parametrize('name', PRINTED)
def test_without_ros(name, capsys):
    said = []

    run = simulate(FOLDER / f'{name}.py', nb_robots=3, duration=30, warn=said.append)

    assert said == []
    assert np.abs(run.poses[-1, :2] - run.poses[0, :2]).max() > 0.5
    printed = capsys.readouterr().out
    for robot in (1, 2, 3):
        assert PRINTED[name].format(i=robot) in printed
