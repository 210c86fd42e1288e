import math
from dataclasses import replace

import pytest

from setcmas_ctrl.pause_reason import PauseCause, PauseReason
from setcmas_expe.guard.guard_decision import GuardSituation, GuardState, StartLatch

PAUSED, SILENT, NOT_STARTED = (
    PauseReason(cause, cause.value)
    for cause in (PauseCause.OPERATOR, PauseCause.SILENT, PauseCause.NOT_STARTED)
)
GO = None
WELL = GuardSituation(
    emergency=False,
    commanders=['/bridge'],
    intruders=[],
    disobeys=False,
    base=None,
    has_ended=False,
)


@pytest.mark.parametrize(
    ('changes', 'pause', 'state'),
    [
        ({}, GO, GuardState.FOLLOWING),
        ({}, PAUSED, GuardState.PAUSED),
        ({}, SILENT, GuardState.HELD),
        ({}, NOT_STARTED, GuardState.HELD),
        ({'has_ended': True}, GO, GuardState.SILENT),
        ({'clearance': 0.2}, GO, GuardState.OBSTRUCTED),
        ({'clearance': 0.2}, PAUSED, GuardState.PAUSED),
        ({'clearance': math.nan}, GO, GuardState.BLIND),
        ({'base': GuardState.UNCONNECTED}, PAUSED, GuardState.UNCONNECTED),
        ({'base': GuardState.OPEN}, PAUSED, GuardState.OPEN),
        ({'disobeys': True}, PAUSED, GuardState.DEAF),
        ({'commanders': ['/bridge', '/rogue']}, PAUSED, GuardState.CONTESTED),
        ({'intruders': ['/rogue']}, PAUSED, GuardState.INTRUDED),
        ({'emergency': True, 'intruders': ['/rogue']}, GO, GuardState.INTRUDED),
        ({'emergency': True}, PAUSED, GuardState.EMERGENCY),
    ],
)
def test_what_a_robot_that_was_paused_may_do(changes, pause, state):
    latch = StartLatch()
    latch.decide(WELL, PAUSED)
    assert latch.decide(replace(WELL, **changes), pause).state is state


STOPS = [
    {'has_ended': True},
    {'clearance': 0.2},
    {'clearance': math.nan},
    {'base': GuardState.OPEN},
    {'disobeys': True},
    {'commanders': ['/bridge', '/rogue']},
    {'intruders': ['/rogue']},
    {'emergency': True},
]


@pytest.mark.parametrize('changes', STOPS, ids=[next(iter(one)) for one in STOPS])
def test_whatever_stopped_a_robot_keeps_it_stopped_until_a_pause_and_then_a_start(changes):
    latch = StartLatch()
    latch.decide(WELL, PAUSED)
    assert latch.decide(WELL, GO).state is GuardState.FOLLOWING
    latch.decide(replace(WELL, **changes), GO)

    for pause in (GO, SILENT, NOT_STARTED, GO):
        assert latch.decide(WELL, pause).state.stops
    latch.decide(WELL, PAUSED)
    assert latch.decide(WELL, GO).state is GuardState.FOLLOWING


def test_a_robot_that_nobody_commands_is_idle_and_then_waits_for_a_start():
    latch, alone = StartLatch(), replace(WELL, commanders=[], has_ended=True)
    assert latch.decide(alone, SILENT).state is GuardState.IDLE
    latch.decide(WELL, PAUSED)
    latch.decide(WELL, GO)
    latch.decide(alone, GO)
    assert latch.decide(alone, GO).state is GuardState.IDLE
    assert latch.decide(WELL, GO).state is GuardState.SILENT


def test_a_reason_names_who_commands_the_robot():
    both = replace(WELL, commanders=['/bridge', '/rogue'])
    assert StartLatch().decide(both, GO).reason == '/bridge and /rogue command it'
