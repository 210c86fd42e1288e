from dataclasses import replace

import pytest

from setcmas_ctrl.experiment_pause import PauseCause, PauseReason
from setcmas_expe.guard.guard_decision import Situation, Source, StartLatch, State

OPERATOR, SILENT, NOT_STARTED = (
    PauseReason(cause, cause.value)
    for cause in (PauseCause.OPERATOR, PauseCause.SILENT, PauseCause.NOT_STARTED)
)
BRIDGE, PAUSE, ROGUE = b'bridge', b'pause', b'rogue'


def test_the_bridge_is_followed_with_the_pause_node_and_no_node_with_a_rogue():
    source = Source()
    assert source.conflict({BRIDGE, PAUSE}, PAUSE, free=False) == ''
    assert source.pinned == BRIDGE
    assert source.conflict({BRIDGE, PAUSE, ROGUE}, PAUSE, free=True) == 'several nodes command it'
    assert source.conflict({BRIDGE, ROGUE}, None, free=True)


def test_no_node_replaces_the_bridge_while_the_robot_may_move():
    source = Source()
    source.conflict({BRIDGE}, None, free=False)
    assert source.conflict({ROGUE}, None, free=True)
    assert source.pinned == BRIDGE

    assert source.conflict({ROGUE}, None, free=False) == ''
    assert source.pinned == ROGUE
    source.conflict(set(), None, free=False)
    assert source.pinned == b''


WELL = Situation(
    emergency=False,
    intruder='',
    conflict='',
    base_listens=True,
    is_commanded=True,
    has_ended=False,
    ending='ended',
)


@pytest.mark.parametrize(
    ('changes', 'paused', 'state'),
    [
        ({}, None, State.FOLLOWING),
        ({}, OPERATOR, State.PAUSED),
        ({}, SILENT, State.HELD),
        ({}, NOT_STARTED, State.HELD),
        ({'is_commanded': False, 'has_ended': True}, SILENT, State.IDLE),
        ({'has_ended': True}, None, State.SILENT),
        ({'base_listens': False}, OPERATOR, State.HELD),
        ({'conflict': 'two'}, OPERATOR, State.RIVAL),
        ({'intruder': 'rogue'}, OPERATOR, State.RIVAL),
        ({'emergency': True, 'intruder': 'rogue'}, None, State.EMERGENCY),
    ],
)
def test_what_a_robot_is_let_do(changes, paused, state):
    latch = StartLatch()
    situation = replace(WELL, **changes)
    assert latch.decide(situation, paused)[0] is state
    assert latch.is_free is (state is State.FOLLOWING)


def test_the_state_says_what_stopped_the_robot_until_it_is_paused():
    latch = StartLatch()
    latch.decide(WELL, None)
    assert latch.reason_to_wait(replace(WELL, has_ended=True)) == 'ended'
    assert latch.decide(WELL, PauseReason(PauseCause.LATCHED, 'ended')) == (State.SILENT, 'ended')
    latch.decide(WELL, OPERATOR)
    assert latch.decide(WELL, NOT_STARTED)[0] is State.HELD
