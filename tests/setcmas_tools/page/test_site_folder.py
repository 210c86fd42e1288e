import base64
import hashlib
import io
import json
import re
import zipfile
from pathlib import Path

import pytest
from page_of_laws import RUBRIC

from launch_scripts.cli import main
from setcmas_simu.errors import SetcmasError
from setcmas_tools.page import site_folder
from setcmas_tools.page.site_folder import CDN, RUBRICS, installed_packages, site
from setcmas_tools.run.scenario import Scenario

TEMPLATES = Path(site_folder.__file__).parent / 'templates' / 'site'
CODEMIRROR = 'afbc4c6eff14cd0d374e9fbdde93392f57093587d32e097aad08dc0dd3661f0e'


def integrity(content):
    return f'sha256-{base64.b64encode(hashlib.sha256(content).digest()).decode()}'


@pytest.fixture(scope='module')
def files():
    return site()


def test_the_folder_has_all_that_the_page_names(files):
    parts = json.loads(files['python.json'])
    for one in (one for half in ('first', 'later') for one in parts[half]):
        if '://' not in one['address']:
            assert one['integrity'] == integrity(files[one['address']]), one
    named = [one['address'] for one in parts['first'] if '://' in one['address']]

    assert all(one.startswith(CDN.format(version='0.27.7')) for one in named)
    assert {'pyodide.asm.wasm', 'python_stdlib.zip'} <= {Path(one).name for one in named}
    assert b"connect-src 'self' https://cdn.jsdelivr.net;" in files['index.html']
    assert sum(map(len, files.values())) < 1.5e6


def test_equal_commands_write_equal_pages(files):
    assert site() == files


def test_the_editor_is_the_bundle_that_was_reviewed():
    content = (TEMPLATES / 'codemirror.js').read_bytes()

    assert hashlib.sha256(content).hexdigest() == CODEMIRROR
    assert b'MIT License' in content[:1000]


def test_hidden_parts_of_rubrics_stay_out(tmp_path):
    (tmp_path / 'lab.yaml').write_text(RUBRIC)
    files = site([str(tmp_path / 'lab.yaml')])
    with zipfile.ZipFile(io.BytesIO(files[RUBRICS])) as packed:
        text = packed.read('rubrics/lab/lab.yaml').decode()
    offered = json.loads(files['catalogue.json'])

    assert 'meet' in text
    assert 'secret' not in text
    assert 'secret' not in files['catalogue.json'].decode()
    assert offered['first'] == 'rubric:lab'
    [lab] = [one for one in offered['sources'] if one['group'] == 'Exercises']
    assert (lab['label'], lab['name']) == ('My rubric (2 points)', 'my_consensus.py')
    assert lab['checks'] == {'rubric': 'lab'}
    assert 'law:consensus' not in [one['key'] for one in offered['sources']]


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('web', '--exercise', 'consensu'), 'did you mean consensus'),
        (('web', '--exercise', 'none.yaml'), "'none.yaml'"),
        (('web', '--pyodide', 'none'), "--pyodide is 'none'; it must be a folder"),
        (('web', '--pyodide', '.'), "lacks 'pyodide-lock.json'"),
        (('none/web',), 'create it'),
        (('full',), "'full' exists and is no page of setcmas"),
        (('full', '--overwrite'), "'full' exists and is no page of setcmas"),
    ],
)
def test_invalid_input_is_refused_in_a_line(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'full').mkdir()
    (tmp_path / 'full' / 'thesis.txt').write_text('mine')
    assert main(['site', *arguments]) == 2

    error = capsys.readouterr().err
    assert message in error
    assert error.count('\n') == 1
    assert [one.name for one in tmp_path.iterdir()] == ['full']
    assert (tmp_path / 'full' / 'thesis.txt').read_text() == 'mine'


@pytest.mark.nightly
def test_a_page_is_replaced_when_asked(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(['site', 'web']) == 0
    (tmp_path / 'web' / 'old.txt').write_text('of the page before')
    assert main(['site', 'web']) == 2
    assert "'web' exists; --overwrite replaces it" in capsys.readouterr().err
    assert main(['site', 'web', '--overwrite']) == 0

    assert not (tmp_path / 'web' / 'old.txt').exists()
    assert [one.name for one in tmp_path.iterdir()] == ['web']


def test_a_folder_of_another_pyodide_is_refused(tmp_path):
    lock = {'info': {'version': '0.20.0'}, 'packages': {}}
    (tmp_path / 'pyodide-lock.json').write_text(json.dumps(lock))

    with pytest.raises(SetcmasError, match=r'has Pyodide 0\.20\.0; it must be 0\.27\.7'):
        site(pyodide=tmp_path)


@pytest.mark.nightly
def test_the_list_of_files_is_that_of_the_release():
    from pyodide_folder import pyodide_folder

    folder = pyodide_folder()  # its PyYAML is pure Python, and has another name
    parts = json.loads(site()['python.json'])
    remote = [
        one for half in ('first', 'later') for one in parts[half] if CDN[:8] in one['address']
    ]
    listed = {one['name']: one['integrity'] for one in remote}
    found = {
        name: integrity((folder / name).read_bytes())
        for name in listed
        if (folder / name).exists()
    }

    assert found.items() <= listed.items()
    names = {name.partition('-')[0] for name in found}
    assert names >= {'pyodide.asm.wasm', 'python_stdlib.zip', 'numpy', 'matplotlib', 'pillow'}


def test_the_packages_are_there_with_their_data_and_entry_points():
    files = installed_packages()
    [points] = [one for path, one in files.items() if path.endswith('/entry_points.txt')]

    assert files.keys() >= {
        'setcmas_ctrl/exercises/consensus.yaml',
        'setcmas_tools/grade/templates/student.html',
        'setcmas_tools/page/templates/player.js',
        'tabulate/__init__.py',
    }
    assert b'unicycle = setcmas_simu.robots.unicycle:UNICYCLE' in points
    assert not [path for path in files if path.startswith('setcmas_expe/guard/')]


@pytest.fixture(scope='module')
def offered(files):
    return json.loads(files['catalogue.json'])


def test_laws_and_exercises_have_their_texts(offered):
    sources = {one['key']: one for one in offered['sources']}
    texts = [one['text'] for one in offered['sources']]
    laws = [one['text'] for key, one in sources.items() if key.startswith('law:')]

    assert len(sources) == len(texts)
    assert len(laws) == len(set(laws))
    assert not [text for text in texts if re.search(r'setcmas (?!_)[a-z]|--[a-z]', text)]
    assert sources['law:kuramoto']['settings'] == ['K', 'W', 'DW', 'SPEED', 'WAIT']  # no state
    assert 'TODO' in sources['exercise:consensus']['text']
    assert sources['exercise:consensus']['label'].endswith('(10 points)')
    assert sources['exercise:ctc']['function'] == 'ctc'
    assert 'def control' in sources['template:']['text']


def test_defaults_of_options_are_those_of_scenarios(offered):
    options = {one['name']: one for one in offered['options']}
    plain = Scenario.of('consensus').values()

    assert {name: one['default'] for name, one in options.items() if name != 'pose'} == {
        name: plain[name] for name in options if name != 'pose'
    }
    assert options['loss'] | {'help': ''} == {
        'name': 'loss', 'help': '', 'input': 'number', 'must_be': 'from 0 to 1', 'default': 0.0,
        'default_text': '', 'unit': '', 'choices': [],
    }  # fmt: skip
    assert 'ring' in options['graph']['choices']
    assert options['event_triggered']['input'] == 'switch'
