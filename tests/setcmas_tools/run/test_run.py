import filecmp
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from circling_fleets import circling_fleet
from runs import run_of

from setcmas_simu.errors import SetcmasError
from setcmas_tools import Run, simulate
from setcmas_tools.run.run_info import RunState, read_info

LAW = """
import numpy as np
import rviz_marker, rviz_marker_array
from setcmas_ctrl import network
task = 'waypoints'
WPL = [[1.0, 1.0]]
def control(i, n, p, t):
    rviz_marker.publish_marker(1, 1, 0, i, marker_name='goal')
    rviz_marker_array.publish_marker(p[0, i - 1], 0, 0, i, marker_name='trail')
    network.send({'x': 1 / 3, 'v': np.array([1.0]), 'A': np.eye(2)} if i > 1 else t)
    if i == 2 and t > 1:
        raise ValueError
    return 0.1 * i, 0
"""


@pytest.fixture(scope='session')
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp('scripts') / 'law.py'
    path.write_text(LAW)
    options = {'graph': 'ring', 'loss': 0.2, 'event_triggered': True, 'filter': 'barrier'}
    run = simulate(path, 3, 3.0, warn=lambda _: None, **options)
    path.write_text('an edit that is not of this run')
    return run


def test_saved_again_it_has_the_same_bytes(run, tmp_path):
    first = run.save(tmp_path / 'first')
    loaded = Run.load(first)
    second = loaded.save(tmp_path / 'second')
    files = [str(p.relative_to(first)) for p in first.rglob('*') if p.is_file()]

    assert sorted(files) == [
        'csv/commands.csv', 'csv/communication.csv', 'csv/drawings.csv', 'csv/fleet.csv',
        'csv/graph.csv', 'csv/messages.csv', 'csv/task.json', 'csv/triggers.csv',
        'inputs/algo/law.py', 'run.yaml',
    ]  # fmt: skip
    assert filecmp.cmpfiles(first, second, files, shallow=False) == (files, [], [])
    assert (second / 'inputs' / 'algo' / 'law.py').read_text() == LAW
    assert replace(loaded.info, origin=None) == run.info
    assert loaded.references == run.references
    np.testing.assert_allclose(loaded.table.x, run.table.x, rtol=0, atol=5.1e-10)
    for name in ('vx', 'allowed_vx'):
        own, read = getattr(run.commands, name), getattr(loaded.commands, name)
        np.testing.assert_allclose(read, own, rtol=0, atol=5.1e-10)
    for own, read in zip(run.messages, loaded.messages, strict=True):
        assert read[:2] == own[:2]
        np.testing.assert_equal(read.value, own.value)


def test_robots_by_name_and_by_number(run):
    assert run.robots == [1, 2, 3]
    np.testing.assert_array_equal(run['tb3_2'].x, run.poses[:, 0, 1])
    np.testing.assert_array_equal(run[2].omega, run.omega[:, 1])
    with pytest.raises(SetcmasError, match=r"no robot 'tb3_4'.*must be one of tb3_1"):
        run['tb3_4']


def test_robots_with_times_of_their_own():
    table = circling_fleet(2)
    run = run_of(table.rows(np.arange(len(table.t)) != 3))

    assert len(run[2].t) == len(run[1].t) - 1
    with pytest.raises(SetcmasError, match=r"states at different times: use run\['tb3_1'\]"):
        run.poses  # noqa: B018
    with pytest.raises(SetcmasError, match='no known ones'):
        run.velocities  # noqa: B018
    assert run.grid(5.0).x.shape == (2, 60)


def test_plots_by_name(run):
    figure = run.plot('trajectories')

    assert figure.axes[0].get_title(loc='right') == 'law, 3 robots'
    assert figure._repr_png_().startswith(b'\x89PNG')
    with pytest.raises(
        SetcmasError, match=r"unknown plot 'trajectory'.*did you mean trajectories"
    ):
        run.plot('trajectory')
    with pytest.raises(SetcmasError, match="plot 'distances' does not apply to this run"):
        run_of(circling_fleet(1)).plot('distances')


def test_a_notebook_shows_picture_and_table(run):
    html = run._repr_html_()

    assert '<img src="data:image/png;base64,' in html
    assert 'least separation' in html
    assert 'law.py failed for robot 2' in html
    assert repr(run.info).endswith('law.py failed for robot 2)')
    assert len(repr(run.info)) < 120


def test_a_data_frame(run):
    pandas = pytest.importorskip('pandas')
    frame = run.to_dataframe()

    assert isinstance(frame, pandas.DataFrame)
    assert list(frame) == ['t', 'robot', 'x', 'y', 'theta', 'v', 'omega']
    assert len(frame) == 31 * 3


def test_without_pandas_the_message_names_what_to_install(run, monkeypatch):
    monkeypatch.setitem(sys.modules, 'pandas', None)

    with pytest.raises(SetcmasError, match=r'pandas is needed.*\[notebook\]'):
        run.to_dataframe()


def test_a_folder_of_csv_files_has_the_task(run, tmp_path):
    out = run.save(tmp_path / 'out')
    (out / 'csv').rename(tmp_path / 'alone')

    assert Run.load(tmp_path / 'alone').references == run.references


def test_a_full_disk_leaves_no_run_that_says_it_is_complete(tmp_path):
    command = (
        'import resource, signal\n'
        'from setcmas_tools import simulate\n'
        "run = simulate('consensus', 8, 60)\n"
        'signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n'
        'resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))\n'
        "run.save('out')\n"
    )
    result = subprocess.run(
        [sys.executable, '-c', command], cwd=tmp_path, capture_output=True, text=True, check=False
    )

    assert "output 'out' cannot be written: File too large" in result.stderr
    assert read_info(tmp_path / 'out').outcome.state is RunState.NOT_FINISHED
