"""Answers of students: what a lecturer sees, and what cannot reach the lecturer's browser."""

import pytest
from report_pages import HOSTILE, Page

from setcmas_simu.errors import SetcmasError

pytest.importorskip('markdown_it')
from setcmas_tools.page.document import answers_html

ATTACKS = [
    HOSTILE,
    '[x](javascript:alert(1))',
    '![x](data:text/html,<script>alert(1)</script>)',
    '<a href="x" onclick="alert(1)">x</a>',
]


def of(text, folder):
    (folder / 'answers.md').write_text(text, encoding='utf-8')
    return Page(answers_html(folder / 'answers.md'))


def tags(page):
    return [tag for tag, _ in page.elements]


def test_markdown_becomes_headings_tables_and_code(tmp_path):
    page = of(
        '# Q1\n\nIt is $u = -K x^2$, ![x](x.png).\n\n|a|b|\n|-|-|\n|1|2|\n\n```\nx = 1\n```\n',
        tmp_path,
    )

    assert tags(page)[:2] == ['h2', 'p']  # the title of the page is its only h1
    assert {'table', 'code'} <= {*tags(page)}
    assert 'It is $u = -K x^2$' in page.shown


@pytest.mark.parametrize('text', ATTACKS)
def test_nothing_that_a_student_writes_runs_or_leads_to_a_script(tmp_path, text):
    for tag, attributes in of(text, tmp_path).elements:
        assert tag not in ('script', 'img', 'iframe')
        assert not [name for name in attributes if name.startswith('on') or 'href' in name]


def test_answers_that_cannot_be_read_are_reported(tmp_path):
    (tmp_path / 'word.md').write_bytes(b'\xff\xfe\x00')

    for name, message in (('gone.md', 'cannot be read'), ('word.md', 'a text file in UTF-8')):
        with pytest.raises(SetcmasError, match=message):
            answers_html(tmp_path / name)
