import pytest

from setcmas_tools.run.inputs import kept_inputs


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
