"""Answers of students: what a lecturer sees, and what cannot reach the lecturer's browser."""

import pytest
from PIL import Image
from report_pages import HOSTILE, Page

from setcmas_simu.errors import SetcmasError

pytest.importorskip('mdit_py_plugins')
from setcmas_tools.page.document import answers_html

ATTACKS = [
    HOSTILE,
    '[x](javascript:alert(1))',
    f'$\\text{{{HOSTILE}}}$',
    '$\\href{javascript:alert(1)}{x}$',
    '![x](data:text/html,<script>alert(1)</script>)',
    '<a href="x" onclick="alert(1)">x</a>',
]


def of(text, folder):
    (folder / 'answers.md').write_text(text, encoding='utf-8')
    return Page(answers_html(folder / 'answers.md'))


def tags(page):
    return [tag for tag, _ in page.elements]


def test_markdown_becomes_headings_tables_code_and_formulas(tmp_path):
    page = of(
        '# Q1\n\nIt is $u = -K x^2$ for $5 and $6.\n\n$$\\frac{1}{2}$$\n\n```\nx = 1\n```\n',
        tmp_path,
    )

    assert tags(page)[:2] == ['h2', 'p']  # the title of the page is its only h1
    assert {'msup', 'mfrac', 'code'} <= {*tags(page)}
    assert 'for $5 and $6.' in page.shown


def test_a_formula_that_is_wrong_stays_as_it_was_written(tmp_path):
    assert ('code', '\\frac{') in of('$\\frac{$', tmp_path).text


@pytest.mark.parametrize('text', ATTACKS)
def test_nothing_that_a_student_writes_runs_or_leads_to_a_script(tmp_path, text):
    for tag, attributes in of(text, tmp_path).elements:
        assert tag not in ('script', 'img', 'iframe')
        assert not [name for name in attributes if name.startswith('on') or 'href' in name]


def test_images_are_in_the_page(tmp_path):
    Image.new('RGB', (2, 2)).save(tmp_path / 'my plot.png')
    page = of('![my plot](my%20plot.png)', tmp_path)

    [(_, image)] = [one for one in page.elements if one[0] == 'img']
    assert image['src'].startswith('data:image/png;base64,')
    assert image['alt'] == 'my plot'


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('![x](gone.png)', "image 'gone.png' cannot be read: No such file"),
        ('![x](answers.md)', "image 'answers.md' cannot be read: it must be one of PNG"),
        ('![x](https://x.org/x.png)', "download the image 'https://x.org/x.png'"),
    ],
)
def test_an_image_that_cannot_be_in_the_page_is_reported(tmp_path, text, message):
    with pytest.raises(SetcmasError, match=message):
        of(text, tmp_path)


def test_answers_that_cannot_be_read_are_reported(tmp_path):
    (tmp_path / 'word.md').write_bytes(b'\xff\xfe\x00')

    for name, message in (('gone.md', 'cannot be read'), ('word.md', 'a text file in UTF-8')):
        with pytest.raises(SetcmasError, match=message):
            answers_html(tmp_path / name)
