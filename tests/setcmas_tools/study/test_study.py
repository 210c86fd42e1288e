import csv
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from matplotlib.cbook import is_math_text

from setcmas_simu.errors import SetcmasError
from setcmas_tools import Study, simulate, sweep
from setcmas_tools.study.study_plots import spread

LAW = """
import numpy as np
from helper import half
K = 0.5
def control(robotNo, nbRobots, poses, t):
    if K > 1.5 and robotNo == 2 and t > 1:
        raise ValueError('too fast')
    gap = K * half(poses[:2].mean(axis=1) - poses[:2, robotNo - 1])
    return gap + 0.01 * np.random.rand(2)
"""
STUDY = {
    'vary': {'K': [0.5, 1.0, 2.0], 'loss': [0, 0.3]},
    'seeds': 2,
    'random_poses': 'auto',
}


@pytest.fixture(scope='session')
def law(tmp_path_factory):
    folder = tmp_path_factory.mktemp('law')
    (folder / 'law.py').write_text(LAW)
    (folder / 'helper.py').write_text('def half(x):\n    return x / 2\n')
    return folder / 'law.py'


@pytest.mark.parametrize(
    ('name', 'values', 'is_in_table'),
    [
        ('event_triggered', [False, True], True),
        ('graph', [[[0, 1], [1, 0]], [[0, 0], [1, 0]]], True),
        ('arena', ['-9,9,-9,9', '-8,8,-8,8'], True),
        ('K', {'slow': 0.1, 'fast': 0.3}, False),
        ('graph', {'both': np.ones((2, 2)) - np.eye(2), 'one': np.array([[0, 0], [1, 0]])}, False),
    ],
)
def test_runs_of_all_kinds_of_values_are_repeated(law, name, values, is_in_table):
    made = sweep(law, 2, 2, jobs=1, vary={name: values})
    for one in [made, Study.load(made.folder)][: 1 + is_in_table]:
        again = one.run(2).metrics()['consensus'].disagreement_at_end_m
        assert again == pytest.approx(made.table['disagreement'][1], rel=1e-8)


@pytest.fixture(scope='session')
def study(law, tmp_path_factory):
    return sweep(law, 3, 8, output=tmp_path_factory.mktemp('study') / 'one', jobs=1, **STUDY)


def test_a_row_is_the_run_of_its_parameters(study, law):
    assert study.table['run'].tolist() == list(range(1, 13))
    assert study.table['K'].tolist() == [0.5, 0.5, 1.0, 1.0, 2.0, 2.0] * 2
    assert study.table['state'].tolist() == (['complete'] * 4 + ['failed'] * 2) * 2
    assert study.table['robots'].tolist() == ([''] * 4 + ['2'] * 2) * 2
    assert 'law.py, line 7: ValueError: too fast' in study.table['message'].iloc[-1]

    run = simulate(law, 3, 8, set={'K': 1.0}, loss=0.3, seed=1, random_poses='auto')
    assert study.table['loss'][9] == 0.3
    for name, value in (
        ('disagreement', run.metrics()['consensus'].disagreement_at_end_m),
        ('least_separation', run.metrics()['separation'].least_separation_m),
        ('lost', run.metrics()['messages'].lost),
    ):
        assert study.table[name][9] == pytest.approx(value, rel=1e-8)


def test_the_folder_keeps_what_repeats_a_run(study, law):
    again = Study.load(study.folder)

    assert again.table.equals(study.table)
    run = again.run(8)
    assert run.metrics()['consensus'].disagreement_at_end_m == pytest.approx(
        study.table['disagreement'][7], rel=1e-8
    )
    assert run.inputs[0].path == (study.folder / 'inputs' / 'algo' / 'law.py').resolve()


def test_the_scripts_of_all_runs_are_kept(tmp_path):
    laws = [tmp_path / name for name in ('one.py', 'two.py')]
    for law in laws:
        law.write_text('def control(*_):\n    return 0.1, 0.0\n')
    study = sweep('consensus', 2, 1, vary={'algo': ['consensus', *laws]}, jobs=1)

    kept = (study.folder / 'inputs' / 'algo').iterdir()
    assert sorted(path.name for path in kept) == ['consensus.py', 'one.py', 'two.py']


def test_rows_do_not_depend_on_the_number_of_workers(study, law, tmp_path):
    sweep(law, 3, 8, output=tmp_path / 'two', jobs=2, **STUDY)

    for name in ('runs.csv', 'run.yaml'):
        assert (tmp_path / 'two' / name).read_bytes() == (study.folder / name).read_bytes()


def test_names_and_values_are_drawn_as_they_are_written(tmp_path):
    law = tmp_path / 'law.py'
    law.write_text("_MODE = ''\n_K = 0\ndef control(*_):\n    return _K, 0\n")
    study = sweep(law, 1, 1, vary={'_MODE': ['a$x_1$', '_{b}'], '_K': [1, 2]}, jobs=1)
    by_mode, by_gain = (study.plot('path_length', by=one).axes[0] for one in ('_MODE', '_K'))
    texts = [one.get_text() for one in by_mode.get_xticklabels()]
    for axes in (by_mode, by_gain):
        texts += [one.get_text() for one in axes.get_legend().get_texts()]

    assert not any(map(is_math_text, texts))
    assert [text.replace(r'\$', '$') for text in texts] == [
        'a$x_1$', '_{b}', '_K = 1', '_K = 2', '_MODE = a$x_1$', '_MODE = _{b}'
    ]  # fmt: skip


def test_medians_and_plots_leave_broken_runs_out(study):
    settled, good = study.numbers('settling_time'), study.table['K'] < 2

    assert np.isinf(settled[good & study.table['settling_time'].isna()]).all()
    assert study.numbers('disagreement')[~good].isna().all()  # a law that failed is no data
    assert [line.split()[2:4] for line in study.summary.splitlines()[-2:]] == [['2', '2']] * 2
    axes = study.plot('disagreement', by='K').axes[0]
    drawn = axes.get_lines()[0].get_ydata()
    assert drawn[0] == pytest.approx(np.median(study.table['disagreement'][[0, 6]]))
    assert np.isnan(drawn[2])
    assert '4 broken runs left out' in axes.texts[-1].get_text()
    for metric, by in (('agreement', 'K'), ('disagreement', 'gain')):
        with pytest.raises(SetcmasError, match='must be'):
            study.plot(metric, by=by)


def test_a_band_has_ends_of_runs_and_inf_counts_as_the_largest():
    values = pd.Series([*range(1, 21), 1, 2, np.inf, np.inf, 3, 1, np.nan])
    band = spread(values, pd.Series(['many'] * 20 + ['half'] * 4 + ['few'] * 3))

    assert band.loc['many'].tolist() == [2, 10.5, 19]
    assert band.loc['half'].tolist() == [1, np.inf, np.inf]
    assert band.loc['few'].tolist() == [1, 2, 3]


def test_words_are_joined_by_no_line():
    study = sweep(
        'consensus', 3, 1, vary={'graph': ['path', 'star', 'ring']}, event_triggered=True
    )

    assert not study.plot('path_length').axes[0].get_legend()
    axes = study.plot('path_length').axes[0]
    assert [line.get_linestyle() for line in axes.get_lines()] == ['None']
    assert axes.get_lines()[0].get_ydata().tolist() == study.table['path_length'].tolist()


def test_functions_and_what_they_are_called():
    def towards(gain):
        def law(robotNo, nbRobots, poses, t):
            return gain * -poses[:2, robotNo - 1]

        return law

    study = sweep(towards(0), 2, 2, vary={'algo': {'slow': towards(0.01), 'fast': towards(1)}})

    assert study.table['algo'].tolist() == ['slow', 'fast']
    assert study.table['path_length'][0] < study.table['path_length'][1]
    each = sweep({1: towards(0), 2: towards(0.01)}, 2, 2, graph=np.ones((2, 2)) - np.eye(2))
    assert each.table['path_length'][0] == pytest.approx(study.table['path_length'][0] / 2)


@pytest.mark.parametrize(
    ('given', 'told'),
    [
        ({'vary': {'gain': [1]}}, 'unknown name'),
        ({'vary': {'K': ['fast']}}, 'must be a number'),
        ({'vary': {'event_triggered': '3'}}, 'must be true or false'),
        ({'vary': {'loss': [2]}}, 'from 0 to 1'),
        ({'vary': {'graph': ['ring', 'rign']}}, r"graph 'rign'.* did you mean ring"),
        ({'vary': {'nb-robots': [2], 'nb_robots': [3]}}, 'varied twice'),
        ({'vary': {'threshold': [0.1, 0.2]}}, 'threshold needs event_triggered'),
        ({'speed': 3}, "has no value 'speed'"),
        ({'seeds': 0}, 'seeds is 0'),
        ({'jobs': 0}, 'jobs is 0'),
        ({'filter': 'barrier', 'vary': {'min_separation': [0.4, 11.0]}}, 'start 10 m apart'),
    ],
)
def test_mistakes_are_reported_before_anything_starts(law, tmp_path, given, told):
    with pytest.raises(SetcmasError, match=told):
        sweep(law, 3, 8, output=tmp_path / 'study', **given)
    assert not (tmp_path / 'study').exists()


def test_metrics_of_ones_own_are_columns(law):
    def spread(run):
        return run.poses[:, 0].max()  # a numpy scalar

    own = {'spread': spread, 'wrong': lambda _: {'a': 1}}
    study = sweep(law, 3, 2, vary={'K': [0.5, 1.0]}, jobs=1, metrics=own)

    run = study.run(1)
    assert study.table['spread'][0] == pytest.approx(spread(run))
    assert study.table['state'].tolist() == ['complete', 'complete']
    assert "metric 'wrong' returned a value of type dict; it must" in study.table['message'][0]
    with pytest.raises(SetcmasError, match='exists already'):
        sweep(law, 3, 2, metrics={'disagreement': spread})


def test_a_folder_with_something_else_is_left_alone(study, law, tmp_path):
    (tmp_path / 'run.yaml').touch()
    for folder, told in ((study.folder, 'an earlier study'), (tmp_path, 'an earlier run')):
        with pytest.raises(SetcmasError, match=told):
            sweep(law, 3, 8, output=folder)
    assert len(Study.load(study.folder)) == 12
    with pytest.raises(SetcmasError, match='must be from 1 to 12'):
        study.run(13)


SCRIPT = """
import math, os
import numpy
DOES = 'nothing'
ACTS = {
    'raises': 'raise ValueError("oh no")',
    'hangs': 'while True: pass',
    'exits': 'os._exit(3)',
    'patches': 'math.atan2 = numpy.array = None',
}
def control(robotNo, nbRobots, poses, t):
    if robotNo == 2 and 1 < t < 1.3:
        exec(ACTS.get(DOES, ''))
    return 0.1, 0.0
"""
EXPECTED = {
    'nothing': ('complete', '', ''),
    'raises': ('failed', '2', 'ValueError: oh no'),
    'hangs': ('died', '2', 'tb3_2: ended after 15 s (--timeout) at law.py, line 13'),
    'exits': ('died', '2', 'exit status 3'),
    'patches': ('complete', '', "'NoneType' object is not callable"),
    'ends': ('complete', '', ''),
}


SCRIPT_OF_STUDY = f"""
from setcmas_tools import sweep
if __name__ == '__main__':
    sweep(
        'law.py', 2, 3, vary={{'DOES': {list(EXPECTED)}}}, jobs=2, timeout=15, seeds=1,
        output='study',
    )
"""


@pytest.mark.nightly
def test_a_script_harms_its_own_run_alone(tmp_path):
    # In an interpreter of its own: one that has run scripts before forks its processes from one
    # that has not loaded what runs of a study share, so a script could break the loading.
    (tmp_path / 'law.py').write_text(SCRIPT)
    (tmp_path / 'study.py').write_text(SCRIPT_OF_STUDY)
    subprocess.run([sys.executable, 'study.py'], cwd=tmp_path, check=True)
    rows = list(csv.DictReader((tmp_path / 'study/runs.csv').read_text().splitlines()))

    assert [row['DOES'] for row in rows] == list(EXPECTED)
    assert rows[0]['disagreement'] == rows[-1]['disagreement'] > '0'
    for row in rows:
        state, robots, message = EXPECTED[row['DOES']]
        assert (row['state'], row['robots']) == (state, robots), (row['DOES'], row['message'])
        assert message in row['message']


LAW_WITH_HELPER = (
    'from helper import K\n\ndef control(robotNo, nbRobots, poses, t):\n    return K, 0.0\n'
)


@pytest.mark.nightly
def test_the_workers_of_a_cluster_make_the_same_table(tmp_path):
    (tmp_path / 'law.py').write_text(LAW_WITH_HELPER)
    (tmp_path / 'helper.py').write_text('K = 0.1\n')
    given = {'vary': {'loss': '0:0.5:3'}, 'seeds': 4, 'random_poses': 'auto'}
    here = sweep(tmp_path / 'law.py', 5, 10, output=tmp_path / 'here', **given)
    (tmp_path / 'study.py').write_text(f"""
import sys
import joblib
from distributed import Client, LocalCluster
from setcmas_tools import sweep
if __name__ == '__main__':
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, Client(cluster) as client, joblib.parallel_config('dask'):
        sweep('law.py', 5, 10, output='there', **{given!r})
        used = client.run(lambda: 'setcmas_tools.study.study' in sys.modules)
        assert all(used.values())
""")
    subprocess.run([sys.executable, 'study.py'], cwd=tmp_path, check=True)

    assert (tmp_path / 'there/runs.csv').read_bytes() == (here.folder / 'runs.csv').read_bytes()


def test_a_script_without_its_main_line_is_told_so(tmp_path):
    script = 'from setcmas_tools import sweep\nsweep("consensus", 2, 1, seeds=9, jobs=1)\n'
    (tmp_path / 'study.py').write_text(script)
    done = subprocess.run(
        [sys.executable, 'study.py'], cwd=tmp_path, capture_output=True, text=True
    )

    assert done.returncode == 1
    assert "must do so below a line if __name__ == '__main__':" in done.stderr.splitlines()[-1]
