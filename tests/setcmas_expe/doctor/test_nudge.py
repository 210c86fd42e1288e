import math

import pytest

pytest.importorskip('rclpy')

from setcmas_expe.doctor.nudge import missing_room
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab

LAB = load_lab(DEFAULT_FILE, 2)
POSES = {1: (1.0, 1.0, math.pi / 2), 2: (-1.0, 0.0, 0.0)}


def test_a_nudge_needs_room():
    assert missing_room(1, POSES, LAB) == ''
    assert 'border' in missing_room(1, POSES | {1: (2.95, 0.0, 0.0)}, LAB)
    assert 'tb3_2' in missing_room(1, POSES | {1: (-1.0, 0.4, 0.0)}, LAB)
