"""The document of a page: its modules as one script, its texts and data as nothing but that."""

import re
from importlib.resources import files

from report_pages import HOSTILE, Page

from setcmas_tools.page.document import _MODULES, document, element, page_script
from setcmas_tools.page.looks import page_content

TEMPLATES = files('setcmas_tools.page') / 'templates'
MODULES = {name: (TEMPLATES / name).read_text(encoding='utf-8') for name in _MODULES}
NAME = r'^(?:export )?(?:const|let|function) (\w+)'


def test_modules_import_what_others_before_them_export():
    assert {path.name for path in TEMPLATES.iterdir() if path.suffix == '.js'} == set(_MODULES)
    for name, text in MODULES.items():
        for names, other in re.findall(r"^import \{(.*?)\} from '\./(.*?)';$", text, re.M):
            assert _MODULES.index(other) < _MODULES.index(name)
            for one in names.split(', '):
                assert re.search(rf'^export .*\b{one}\b', MODULES[other], re.M), (name, one)


def test_as_one_script_they_clash_in_no_name():
    names = [one for text in MODULES.values() for one in re.findall(NAME, text, re.M)]

    assert len(set(names)) == len(names)
    assert not re.search('^(import|export)', page_script(), re.M)


def test_texts_and_data_are_never_html():
    content = page_content(charts=[{'name': HOSTILE, 'values': {}}])
    page = Page(document(HOSTILE, [element('p', HOSTILE + '\x00\x1b')], content))

    assert page.data['charts'][0]['name'] == HOSTILE
    assert HOSTILE in page.shown
    assert not [tag for tag, _ in page.elements if tag == 'img']


def test_only_a_live_page_connects():
    assert "connect-src 'self'" not in document('', [], page_content())
    assert "connect-src 'self'" in document('', [], page_content(live={'commands': False}))
