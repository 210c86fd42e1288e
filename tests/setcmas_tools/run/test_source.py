"""Where the outputs of a run go by default."""

import pytest

from setcmas_tools.run.source import find_run


@pytest.mark.parametrize(
    ('bag', 'plots'),
    [('bag', 'plots'), ('rec', 'rec_plots'), ('lab.1', 'lab.1_plots'), ('lab.2', 'lab.2_plots')],
)
def test_each_bag_of_a_folder_has_plots_of_its_own(tmp_path, bag, plots):
    (tmp_path / bag).mkdir()
    (tmp_path / bag / 'metadata.yaml').touch()

    assert find_run(tmp_path / bag).plots == tmp_path / plots


def test_recordings_that_differ_in_their_kind_only_share_nothing(tmp_path):
    (tmp_path / 'lab.mcap').touch()
    assert find_run(tmp_path / 'lab.mcap').plots == tmp_path / 'lab_plots'

    (tmp_path / 'lab').mkdir()
    (tmp_path / 'lab' / 'metadata.yaml').touch()
    (tmp_path / 'lab.db3').touch()
    found = [find_run(tmp_path / name).plots.name for name in ('lab', 'lab.mcap', 'lab.db3')]
    assert found == ['lab_plots', 'lab.mcap_plots', 'lab.db3_plots']
