import pytest
from processes import refuses, run_here

from setcmas_tools import simulate


@pytest.fixture
def run(tmp_path):
    """The folder of a run of three robots."""
    return simulate('consensus', 3, 5.0).save(tmp_path / 'out')


def test_the_table(run):
    result = run_here('explain', 'out', cwd=run.parent)

    assert result.returncode == 0, result.stderr
    assert 'as unicycle' in result.stdout


def test_a_run_without_a_law(run):
    (run / 'run.yaml').unlink()

    refuses('explain', 'out', message="'out' has no run.yaml", cwd=run.parent)
