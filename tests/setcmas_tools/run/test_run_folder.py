"""Where the outputs of a run go by default."""

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.run_folder import RunFolder, find_run, kept_inputs
from setcmas_tools.run.run_info import RunInfo


@pytest.mark.parametrize(
    ('place', 'stem'),
    [('out', ''), ('out/csv', ''), ('out/csv/fleet.csv', ''), ('lab.csv', 'lab_')],
)
def test_a_run_is_found_by_its_folder_or_its_table(tmp_path, place, stem):
    (tmp_path / 'out' / 'csv').mkdir(parents=True)
    for table in ('out/csv/fleet.csv', 'lab.csv'):
        (tmp_path / table).touch()
    source = find_run(tmp_path / place)

    assert source.stem == stem
    assert source.folder == (tmp_path if stem else tmp_path / 'out')


def test_an_earlier_run_is_not_lost_by_mistake(tmp_path):
    folder = RunFolder(tmp_path / 'out')
    folder.check(overwrite=False)
    folder.create(RunInfo())
    folder.bag.mkdir()

    with pytest.raises(SetcmasError, match=r'holds an earlier run.*--overwrite'):
        folder.check(overwrite=False)
    folder.check(overwrite=True)


def test_a_run_leaves_nothing_of_the_study_that_it_replaces(tmp_path):
    folder = RunFolder(tmp_path)
    folder.create(RunInfo())
    (tmp_path / 'runs.csv').touch()

    with pytest.raises(SetcmasError, match=r'holds an earlier study.*--overwrite'):
        folder.check(overwrite=False)
    folder.create(RunInfo())
    assert [path.name for path in tmp_path.iterdir()] == ['run.yaml']


def test_a_folder_that_is_no_run_is_never_overwritten(tmp_path):
    (tmp_path / 'csv').mkdir()

    with pytest.raises(SetcmasError, match=r'holds csv and no run\.yaml'):
        RunFolder(tmp_path).check(overwrite=True)


def test_files_of_a_run_that_never_began_are_removed(tmp_path):
    folder = RunFolder(tmp_path / 'out')
    folder.create(RunInfo())
    folder.bag.mkdir()
    folder.discard()
    assert not folder.path.exists()

    folder.create(RunInfo())
    (folder.path / 'mine').touch()
    folder.discard()
    assert [path.name for path in folder.path.iterdir()] == ['mine']


def test_overwriting_removes_the_earlier_run_and_nothing_else(tmp_path):
    for name in ('bag', 'csv', 'plots', 'mine'):
        (tmp_path / name).mkdir()
    (tmp_path / 'run.yaml').touch()
    (tmp_path / 'inputs').symlink_to(tmp_path / 'mine')

    RunFolder(tmp_path).create(RunInfo())

    assert sorted(path.name for path in tmp_path.iterdir()) == ['mine', 'run.yaml']


@pytest.mark.parametrize(
    ('bag', 'plots'),
    [('bag', 'plots'), ('rec', 'rec_plots'), ('lab.1', 'lab.1_plots'), ('lab.2', 'lab.2_plots')],
)
def test_each_bag_of_a_folder_has_plots_of_its_own(tmp_path, bag, plots):
    (tmp_path / bag).mkdir()
    (tmp_path / bag / 'metadata.yaml').touch()

    assert find_run(tmp_path / bag).plots == tmp_path / plots


def strange(run, path):
    """A file outside of a run's inputs, reached in the way of its name."""
    secret = run.parent / 'secret.py'
    secret.write_text('secret = 1')
    kept = run / 'inputs' / 'algo'
    kept.mkdir(parents=True)
    (kept / 'law.py').write_text('import helper')
    (kept / 'link.py').symlink_to(secret)
    (run / 'inputs' / 'away').symlink_to(run.parent)
    (kept / 'large.py').write_text('#' * 3_000_000)
    return path.format(secret=secret)


@pytest.mark.parametrize(
    'path',
    [
        '{secret}', '../secret.py', 'inputs/../../secret.py', 'inputs/algo/link.py',
        'inputs/away/secret.py', 'inputs/algo/large.py', 'inputs/algo', 'run.yaml', 'inputs',
        '/proc/self/environ', '',
    ],
)  # fmt: skip
def test_files_outside_of_its_inputs_are_none_of_a_run(tmp_path, path):
    run = tmp_path / 'run'
    run.mkdir()
    (run / 'run.yaml').touch()

    assert kept_inputs(run, {'algo': strange(run, path)}) == ()


def test_a_module_that_is_a_link_takes_its_script_away(tmp_path):
    run = tmp_path / 'run'
    strange(run, '')
    assert kept_inputs(run, {'algo': 'inputs/algo/law.py'})
    (run / 'inputs' / 'algo' / 'helper.py').symlink_to(tmp_path / 'secret.py')

    assert kept_inputs(run, {'algo': 'inputs/algo/law.py'}) == ()
