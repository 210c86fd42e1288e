import pytest
from processes import run_here

from setcmas_tools import simulate


@pytest.fixture(scope='session')
def run(tmp_path_factory):
    return str(simulate('consensus', 2, 1.0).save(tmp_path_factory.mktemp('view') / 'run'))


def test_mistakes_are_reported_in_one_line(run):
    for arguments, message in (
        ([f'{run}/none'], 'there is no'),
        ([run, run, run], '3 runs given; name one or two'),
        ([run, '--at', 'noon'], "'noon'"),
        (['--at', '3'], '--at is for a finished run; name its folder'),
        ([run, '--write-rviz', 'x.rviz'], '--write-rviz is for running robots'),
    ):
        done = run_here('view', *arguments)
        assert done.returncode == 2, done.stderr
        assert message in done.stderr
        assert 'Traceback' not in done.stderr
