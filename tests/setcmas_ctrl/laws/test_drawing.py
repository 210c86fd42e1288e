from pathlib import Path

import pytest
from control_functions import load_control


@pytest.mark.parametrize('arguments', ['1, 2, 0, 1, "red"', '"a", 2, 0, 1', '1, 2, 0, 1, [1, 0]'])
@pytest.mark.parametrize('module', ['rviz_marker', 'rviz_marker_array'])
def test_mistakes_in_drawing_are_reported_without_ros_too(script, module, arguments):
    call = f'{module}.publish_marker({arguments})'
    path = script(f'import {module}\ndef control(i, n, p, t):\n    {call}\n    return 0, 0\n')

    with pytest.raises(TypeError, match=r'must be numbers, and color \[red, green, blue\]'):
        load_control(Path(path), 1)(1, 1, None, 0.0)


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        ('1, 2, 0, i, marker_name="my ref"', 'must be a robot number and a name'),
        ('1, 2, 0, i, marker_name=""', 'must be a robot number and a name'),
        ('1, 2, 0, i, marker_name=3', 'must be a robot number and a name'),
        ('1, 2, 0, "tb3_1"', 'must be a robot number and a name'),
        ('1, 2, 0, 0.5', 'must be a robot number and a name'),
        ('1, 2, 0, i, marker_name="odom"', 'a topic of the robot itself'),
    ],
)
def test_names_that_cannot_be_drawn_on_are_reported_without_ros_too(script, arguments, message):
    call = f'rviz_marker.publish_marker({arguments})'
    path = script(f'import rviz_marker\ndef control(i, n, p, t):\n    {call}\n    return 0, 0\n')

    with pytest.raises((TypeError, ValueError), match=message):
        load_control(Path(path), 1)(1, 1, None, 0.0)


def test_the_number_of_a_robot_may_be_a_float_or_of_numpy(script):
    path = script(
        """
        import numpy as np
        import rviz_marker
        def control(robotNo, nbRobots, poses, t):
            rviz_marker.publish_marker(1, 2, 0, np.int64(robotNo))
            rviz_marker.publish_marker(1, 2, 0, 1.0, marker_name='Ref_2/a')
            return 0, 0
        """,
    )

    assert load_control(Path(path), 1)(1, 1, None, 0.0) == (0, 0)
