import math

import pytest

from setcmas_expe.doctor import nudge
from setcmas_expe.doctor.findings import OK, PROBLEM
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab

LAB = load_lab(DEFAULT_FILE, 2)
BEFORE = {1: (1.0, 1.0, math.pi / 2), 2: (-1.0, 0.0, 0.0)}


def after(robot, dx, dy):
    x, y, theta = BEFORE[robot]
    return BEFORE | {robot: (x + dx, y + dy, theta)}


def test_the_right_body_going_along_its_heading_is_well():
    finding = nudge.forward_finding(1, BEFORE, after(1, 0.002, 0.05))

    assert finding.level == OK
    assert '5.0 cm' in finding.found


@pytest.mark.parametrize(
    ('poses', 'found', 'advice'),
    [
        (BEFORE, 'does not move', 'motors'),
        (after(2, 0.05, 0.0), 'tb3_2 moved instead', 'mocap_name'),
        (after(1, 0.0, -0.05), 'backward', 'reversed'),
        (after(1, 0.05, 0.0), '-90 deg', 'heading'),
    ],
)
def test_what_is_wrong_is_told_with_its_remedy(poses, found, advice):
    finding = nudge.forward_finding(1, BEFORE, poses)

    assert finding.level == PROBLEM
    assert found in finding.found
    assert advice in finding.advice


@pytest.mark.parametrize(
    ('turned', 'level', 'advice'),
    [(0.25, OK, ''), (-0.25, PROBLEM, 'wrong sign'), (0.0, PROBLEM, 'does not follow')],
)
def test_a_turn_to_the_left_increases_the_heading(turned, level, advice):
    finding = nudge.turn_finding(1, (0.0, 0.0, math.pi - 0.1), (0.0, 0.0, turned + math.pi - 0.1))

    assert finding.level == level
    assert advice in finding.advice


def test_a_nudge_needs_room():
    assert nudge.obstacle(1, BEFORE, LAB) == ''
    assert 'border' in nudge.obstacle(1, BEFORE | {1: (2.95, 0.0, 0.0)}, LAB)
    assert 'tb3_2' in nudge.obstacle(1, BEFORE | {1: (-1.0, 0.4, 0.0)}, LAB)
