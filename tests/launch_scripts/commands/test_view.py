import pytest
from processes import run_setcmas

from setcmas_tools import simulate


@pytest.fixture(scope='module')
def run(tmp_path_factory):
    return str(simulate('consensus', 2, 1.0).save(tmp_path_factory.mktemp('view') / 'run'))


def test_what_cannot_be_shown_is_told_in_a_line(run):
    for arguments, told in (
        ([f'{run}/none'], 'there is no'),
        ([run, run, run], '3 runs given; name one or two'),
        ([run, '--at', 'noon'], "'noon'"),
        (['--at', '3'], '--at is for a finished run; name its folder'),
        ([run, '--write-rviz', 'x.rviz'], '--write-rviz is for running robots'),
    ):
        done = run_setcmas('view', *arguments)
        assert done.returncode == 2, done.stderr
        assert told in done.stderr
        assert 'Traceback' not in done.stderr
