from pathlib import Path

import pytest

from setcmas_simu.script_calls import CurrentCall, Function, ScriptCall


def test_between_calls_none_is_running():
    call = CurrentCall()
    assert call.last() is None
    assert call.running() is None

    call.begin(3, Path('law.py'), Function.LOADING)
    assert call.running_s(call.since + 2.5) == pytest.approx(2.5)
    call.end()

    assert call.running() is None
    assert call.running_s(12.5) == 0.0
    assert call.last() == ScriptCall(3, 'law.py', Function.LOADING)
