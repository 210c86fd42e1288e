import os

import pytest

pytest.importorskip('rclpy')

from setcmas_expe.bridge.bridge_decision import BridgeState, Cause, Decision, StopReason
from setcmas_expe.bridge.bridged_fleet import BridgedFleet
from setcmas_expe.bridge.machine_load import OVERLOADED
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab


@pytest.mark.parametrize(
    ('cause', 'is_named'),
    [(Cause.NO_COMMAND, True), (Cause.POSE_LATE, True), (Cause.POSE_REJECTED, False)],
)
def test_load_is_named_only_where_it_may_be_the_cause(peer, monkeypatch, cause, is_named):
    monkeypatch.setattr(os, 'getloadavg', lambda: (999.0, 999.0, 999.0))
    fleet, said = BridgedFleet(peer.node, load_lab(DEFAULT_FILE, 1)), []
    fleet.warn = said.append
    fleet.note({1: Decision(0.0, 0.0, BridgeState.STOPPED, StopReason(cause))}, 0.0)

    assert (OVERLOADED in said) is is_named
