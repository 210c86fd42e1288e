import re

from setcmas_tools.plots.plot import plots_of
from setcmas_tools.report.pair import Pair
from setcmas_tools.report.pdf import write_pdf


def nb_pages(path):
    return len(re.findall(rb'/Type /Page\b', path.read_bytes()))


def test_figures_plots_and_script_have_pages(failed_run, tmp_path):
    path = tmp_path / 'run.pdf'
    write_pdf(Pair('failed', failed_run), path)

    assert nb_pages(path) == 1 + len(plots_of(failed_run)) + 1


def test_a_long_script_goes_on_and_equal_runs_give_equal_files(failed_run, tmp_path):
    given = failed_run.inputs[0]
    before = given.contents
    given.contents = [before[0] + b'# a comment\n' * 100]
    try:
        for name in ('one.pdf', 'two.pdf'):
            write_pdf(Pair('failed', failed_run), tmp_path / name)
    finally:
        given.contents = before

    assert nb_pages(tmp_path / 'one.pdf') == 1 + len(plots_of(failed_run)) + 2
    assert (tmp_path / 'one.pdf').read_bytes() == (tmp_path / 'two.pdf').read_bytes()
