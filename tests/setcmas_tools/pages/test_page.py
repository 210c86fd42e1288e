import pytest
from jinja2 import DictLoader, UndefinedError

from setcmas_tools.pages.page import rendered, templates, write_page

MARK = '\N{REPLACEMENT CHARACTER}'


@pytest.fixture
def found():
    """The templates of reports, and one that all could have."""
    own = "{% extends 'page.html' %}{% block title %}{{ name }}{% endblock %}"
    found = templates('setcmas_tools.report')
    found.loader.loaders.insert(0, DictLoader({'own.html': own}))
    return found


def test_what_is_filled_in_is_escaped_and_has_no_control_characters(found):
    page = rendered(found, 'own.html', name='<b>\x00&\x1b')

    assert f'<title>&lt;b&gt;{MARK}&amp;{MARK}</title>' in page
    assert page.startswith('<!DOCTYPE html>')
    assert "default-src 'none'" in page


def test_a_name_that_is_not_filled_in_is_a_mistake(found):
    with pytest.raises(UndefinedError):
        rendered(found, 'own.html')


def test_what_no_encoding_has_is_replaced(tmp_path):
    write_page(tmp_path / 'page.html', 'a \ud800 b')

    assert (tmp_path / 'page.html').read_text() == 'a ? b'
