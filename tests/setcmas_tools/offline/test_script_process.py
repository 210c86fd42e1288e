"""What a function in a process of its own returns, raises and prints, and how it ends."""

import signal
from functools import partial
from pathlib import Path

import process_functions
import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.offline.script_process import ScriptEndedError, ScriptProcess, StartError

needs_posix = pytest.mark.skipif(not hasattr(signal, 'SIGUSR1'), reason='signals and limits')


def result_of(function, *arguments, said=print, **limits):
    scripts = [Path(process_functions.__file__)]
    with ScriptProcess(partial(function, *arguments), scripts) as process:
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


@pytest.mark.parametrize('error', [SetcmasError('a mistake'), StartError('too many')])
def test_mistakes_of_the_user_cross_processes(error):
    with pytest.raises(type(error)) as raised:
        result_of(process_functions.fail, error)

    assert str(error) == str(raised.value)


def test_other_errors_are_those_of_a_script():
    with pytest.raises(ScriptEndedError, match='has broken the simulation itself: ValueError: a'):
        result_of(process_functions.fail, ValueError('a'))


@needs_posix
def test_a_function_that_takes_too_long_is_ended_with_its_place():
    with pytest.raises(ScriptEndedError, match=r'after 0\.5 s .* at process_functions'):
        result_of(process_functions.sleep, timeout=0.5)
