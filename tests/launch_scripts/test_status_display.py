import io

import pytest
from rich.console import Console

from launch_scripts.status_display import StatusDisplay, picture
from setcmas_expe.bridge.bridge_decision import BridgeState
from setcmas_expe.bridge.bridge_report import BridgeReport
from setcmas_expe.pause.console import Status

REASON = 'closer than 0.35 m to robots 2-4; only motion apart is let through'


def status(paused=False, emergency=False, state=BridgeState.MOVING):
    robots = (
        BridgeReport(
            name='tb3_1',
            level=1,
            reason=REASON,
            state=state,
            ready=True,
            pose_age=0.02,
            battery=87,
            speed=0.004,
        ),
        BridgeReport(name='tb3_12', level=2, reason='paused; not seen yet', why='not seen yet'),
    )
    return Status(paused, emergency, 'by space bar', robots)


@pytest.mark.parametrize('width', [60, 80, 130])
def test_a_narrow_terminal_cuts_the_reason_and_nothing_else(width):
    text = io.StringIO()
    Console(file=text, width=width).print(picture(status()))
    lines = text.getvalue().splitlines()

    assert len(lines) == 5
    assert 'RUNNING' in lines[0]
    assert lines[3].split()[:8] == ['tb3_1', '0.02', 's', '87', '%', '0.00', 'm/s', 'moving']
    assert lines[4].split() == ['tb3_12', '-', '-', '-', 'stopped', 'not', 'seen', 'yet']
    assert (REASON in lines[3]) == (width == 130)


def test_robots_that_stop_by_themselves_are_not_said_to_be_stopped_by_a_key():
    text = io.StringIO()
    Console(file=text).print(picture(status(state=BridgeState.STOPPED)))

    assert text.getvalue().splitlines()[0].strip() == 'STOPPED'


def test_the_headline_says_what_robots_do_and_only_when_it_changes():
    text = io.StringIO()
    display = StatusDisplay(text)
    said = [status(True), status(True), status(), status(), status(state=BridgeState.STOPPED)]
    for one in (*said, status(True, emergency=True)):
        display.show(one)
    display.close()

    headlines = [line.partition(';')[0] for line in text.getvalue().splitlines()]
    assert headlines == ['PAUSED', 'RUNNING', 'STOPPED', 'STOP HELD']
