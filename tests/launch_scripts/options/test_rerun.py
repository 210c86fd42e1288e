import pytest
from metrics_runs import T, table, write_run

from launch_scripts.cli import main


@pytest.fixture
def out(tmp_path):
    return write_run(tmp_path / 'out', table((T, T, 0.0)))


@pytest.mark.parametrize('chosen', [None, 'mine.rrd'])
def test_the_file_is_beside_the_run_or_where_it_is_to_be(out, monkeypatch, capsys, chosen):
    pytest.importorskip('rerun')
    monkeypatch.chdir(out.parent)

    assert main(['view', 'out', '--rerun', *([chosen] if chosen else [])]) == 0
    file = chosen or 'out/run.rrd'
    assert (out.parent / file).read_bytes()[:3] == b'RRF'
    assert capsys.readouterr().out == f'{file}: rerun {file} shows it\n'


@pytest.mark.parametrize(
    ('arguments', 'told'),
    [
        (['--rerun'], 'name it first'),
        (['--rerun', 'out'], 'name it first'),
        (['out', '--rerun', 'out'], "'out' must end in .rrd"),
        (['out', 'out', '--rerun'], '--rerun writes one run'),
        (['out', '--at', '3', '--rerun'], '--at is not for the file of --rerun'),
        (['nowhere', '--rerun'], "there is no 'nowhere'"),
        (['out', '--rerun', 'no/folder/x.rrd'], "'no/folder/x.rrd' cannot be written: No such"),
    ],
)
def test_mistakes_get_one_line(out, monkeypatch, capsys, arguments, told):
    pytest.importorskip('rerun')
    monkeypatch.chdir(out.parent)

    assert main(['view', *arguments]) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count('\n') == 1


def test_without_rerun_the_command_that_installs_it_is_told(out, monkeypatch, capsys):
    monkeypatch.setattr('importlib.util.find_spec', lambda _: None)

    assert main(['view', str(out), '--rerun']) == 2
    assert "pip install 'rerun-sdk>=0.39'" in capsys.readouterr().err
