"""What a function in a process of its own returns, raises and prints, and how it ends."""

import signal
from functools import partial
from pathlib import Path

import process_functions
import pytest

from setcmas_ctrl.scripts.script_errors import ControlError
from setcmas_simu.errors import SetcmasError
from setcmas_simu.reports.script_calls import Function
from setcmas_tools.offline.script_process import EndedError, MachineError, ScriptProcess

needs_posix = pytest.mark.skipif(not hasattr(signal, 'SIGUSR1'), reason='signals and limits')


def result_of(function, *arguments, said=print, memory=None, **limits):
    scripts = [Path(process_functions.__file__)]
    with ScriptProcess(partial(function, *arguments), scripts, memory=memory) as process:
        return process.result(said, **limits)


@needs_posix
def test_a_function_returns_a_value_prints_and_warns_where_it_was_called(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    said = []

    assert result_of(process_functions.talk, said=said.append) == tmp_path

    printed = capsys.readouterr()
    assert printed.out == 'to stdout\nhalf a line'
    assert printed.err == 'to stderr\n'
    assert said == ['a warning']


@pytest.mark.parametrize('error', [SetcmasError('a mistake'), MachineError()])
def test_mistakes_of_the_user_cross_processes(error):
    with pytest.raises(type(error)) as raised:
        result_of(process_functions.fail, error)

    assert str(error) == str(raised.value)


@pytest.mark.parametrize(
    'error',
    [
        EndedError('it is over', 3, Function.STEP, 'law.py', 4),
        ControlError('a message', ('key', 1), 'stops', (Path('law.py'), 5)),
    ],
)
def test_other_errors_cross_processes_with_their_attributes(error):
    carried = result_of(process_functions.carry, error)

    assert vars(carried) == vars(error)
    assert str(carried) == str(error)
    with pytest.raises(EndedError, match='the script has broken the simulation itself: '):
        result_of(process_functions.fail, error)


@needs_posix
def test_a_function_that_takes_too_long_is_ended_with_its_place():
    with pytest.raises(EndedError, match=r'ended after 0\.5 s \(--timeout\) at process_functions'):
        result_of(process_functions.sleep, timeout=0.5)


@needs_posix
def test_a_function_may_have_a_limit_of_memory():
    with pytest.raises(EndedError, match='MemoryError'):
        result_of(process_functions.take_memory, memory=2**32)
