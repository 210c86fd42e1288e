import io

import pytest
from rich.console import Console

from launch_scripts.terminal.status_display import StatusDisplay, picture
from setcmas_expe.pause.console_protocol import RobotStatus, Status
from setcmas_expe.safety.decision import State

REASON = 'nearer than 0.35 m to tb3_2, tb3_3, tb3_4; only motion apart is let through'


def status(paused=False):
    robots = (
        RobotStatus('tb3_1', 1, State.STOPPED, REASON, '0.02', '87', '0.004', False, True),
        RobotStatus('tb3_12', 2, State.STOPPED, 'not seen yet', '', '', '', False, False),
    )
    return Status(paused, 'by space bar', robots)


@pytest.mark.parametrize('width', [60, 80, 130])
def test_a_narrow_terminal_cuts_the_reason_and_nothing_else(width):
    text = io.StringIO()
    Console(file=text, width=width).print(picture(status()))
    lines = text.getvalue().splitlines()

    assert len(lines) == 4
    assert 'RUNNING' in lines[0]
    assert lines[2].split()[:8] == ['tb3_1', '0.02', 's', '87', '%', '0.00', 'm/s', 'stopped']
    assert lines[3].split() == ['tb3_12', '-', '-', '-', 'stopped', 'not', 'seen', 'yet']
    assert (REASON in lines[2]) == (width == 130)


def test_without_a_terminal_the_status_is_told_when_it_changes():
    text = io.StringIO()
    display = StatusDisplay(text)
    for paused in (True, True, False, False, False):
        display.show(status(paused))
    display.close()

    assert [line.partition(';')[0] for line in text.getvalue().splitlines()] == [
        'PAUSED',
        'RUNNING',
    ]
