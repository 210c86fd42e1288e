import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.report.files import check_page, page_named_after, write_report


def test_a_page_is_named_after_its_run(failed, tmp_path):
    assert str(page_named_after(failed)) == 'failed.html'
    assert str(page_named_after(failed / 'csv')) == 'failed.html'
    assert str(page_named_after(failed / 'csv' / 'fleet.csv')) == 'failed.html'


@pytest.mark.parametrize(
    ('page', 'message'),
    [('out.pdf', r"the page '.*out\.pdf' must end with \.html"), ('no/out.html', 'no folder')],
)
def test_a_page_that_cannot_be_written_is_told_before(tmp_path, page, message):
    with pytest.raises(SetcmasError, match=message):
        check_page(tmp_path / page)


def test_a_folder_in_the_way_is_told(failed, tmp_path):
    (tmp_path / 'run.html').mkdir()

    with pytest.raises(SetcmasError, match=r"run\.html' cannot be written: Is a directory"):
        write_report([failed], tmp_path / 'run.html', print)
