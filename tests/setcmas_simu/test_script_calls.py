import os
import subprocess
import sys
from pathlib import Path

import pytest

from setcmas_simu.script_calls import CurrentCall, Function, ScriptCall, shared_file

PROGRAM = """
import os, signal, sys
from pathlib import Path
from setcmas_simu.script_calls import CurrentCall
from setcmas_simu.script_calls import Function
call = CurrentCall.shared(int(sys.argv[1]))
call.begin(1, Path('a/long_name_of_a_law.py'))
call.end()
call.begin(7, Path('law.py'), Function.CONDITION)
{end}
"""
ENDS = [
    'os._exit(0)',
    'os.kill(os.getpid(), signal.SIGKILL)',
    'os.closerange(0, 100); os.abort()',
    'import ctypes; ctypes.string_at(0)',
]


@pytest.mark.parametrize('end', ENDS)
def test_the_call_in_which_a_process_ended_is_known_however_it_ended(end):
    file = shared_file()
    call = CurrentCall.shared(file)
    command = [sys.executable, '-c', PROGRAM.format(end=end), str(file)]
    subprocess.run(command, pass_fds=[file], stderr=subprocess.DEVNULL, check=False)

    assert call.running() == call.last() == ScriptCall(7, 'law.py', Function.CONDITION)
    os.close(file)


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
