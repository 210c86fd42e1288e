import base64
import hashlib
import io
import json
import shutil
import zipfile
from pathlib import Path

import pytest
from browser import open_browser, wait_for
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from served_folder import served

from launch_scripts.cli import main
from launch_scripts.commands.site import CDN, site
from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_simu.errors import SetcmasError
from setcmas_tools.page.document import site_files
from setcmas_tools.run.run import Run

TEMPLATES = Path(site_files.__code__.co_filename).parent / 'templates' / 'site'
CODEMIRROR = 'afbc4c6eff14cd0d374e9fbdde93392f57093587d32e097aad08dc0dd3661f0e'
RUBRIC = """
title: My rubric
exercise: consensus
scenarios:
  - name: shown
    nb_robots: 3
    duration: 20
    criteria:
      - {name: meet, metric: disagreement, at_most: 0.1, points: 2}
      - {name: secret, metric: end_error, at_most: 0.1, points: 1, hidden: true}
  - name: secret too
    hidden: true
    nb_robots: 7
    criteria: [{name: meet, metric: disagreement, at_most: 0.1, points: 3}]
"""
SCENARIO = 'algo: law.py\nnb_robots: 4\nduration: 5\nloss: 0.5\nset: {K: 0.5}\n'
LAW = """
K = 1.0

def control(robotNo, nbRobots, poses, t):
    if robotNo == 2 and t == 0:
        print('hello <b>bold</b>')
    x = -K * poses[0, robotNo - 1]
    y = -K * poses[1, robotNo - 1]
    return x, y
"""


def integrity(content):
    return f'sha256-{base64.b64encode(hashlib.sha256(content).digest()).decode()}'


@pytest.fixture
def given(tmp_path):
    (tmp_path / 'lab.yaml').write_text(RUBRIC)
    (tmp_path / 'law.py').write_text(LAW)
    (tmp_path / 'square.yaml').write_text(SCENARIO)
    return tmp_path


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


def test_own_modules_are_few():
    own = [one for one in TEMPLATES.glob('*.js') if one.name != 'codemirror.js']
    assert sum(len(one.read_text().splitlines()) for one in own) < 800


def test_hidden_parts_of_rubrics_stay_out(given):
    files = site([str(given / 'lab.yaml')])
    with zipfile.ZipFile(io.BytesIO(files['packed.zip'])) as packed:
        text = packed.read('rubrics/lab/lab.yaml').decode()
    offered = json.loads(files['catalogue.json'])

    assert 'meet' in text
    assert 'secret' not in text
    assert 'secret' not in files['catalogue.json'].decode()
    assert (offered['first'], offered['exercises']) == ('rubric:lab', [])
    assert 'consensus' not in [one['name'] for one in offered['laws']]


def test_scenarios_are_packed_with_their_scripts(given):
    files = site(scenarios=[given / 'square.yaml'])
    with zipfile.ZipFile(io.BytesIO(files['packed.zip'])) as packed:
        assert packed.read('scenarios/square/law.py').decode() == LAW
        assert packed.read('scenarios/square/square.yaml').decode() == SCENARIO
    assert json.loads(files['catalogue.json'])['first'] == 'scenario:square'


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('web', '--exercise', 'consensu'), 'did you mean consensus'),
        (('web', '--exercise', 'none.yaml'), "'none.yaml'"),
        (('web', '--scenario', 'none.yaml'), "'none.yaml'"),
        (('web', '--pyodide', 'none'), "--pyodide is 'none'; it must be a folder, or an address"),
        (('web', '--pyodide', 'http://example.org/'), "--pyodide is 'http://example.org/'"),
        (('web', '--pyodide', 'https://a.org/;script-src'), 'such as https://'),
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
        site(place=str(tmp_path))


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


# In Chromium with Pyodide


class Page:
    """The page in Chromium."""

    def __init__(self, browser, address, downloads, asked):
        self.browser, self.asked = browser, asked
        self.address = f'{address}/index.html'
        self.downloads = downloads

    def open(self, fragment=''):
        self.browser.get('about:blank')
        self.browser.get(self.address + fragment)
        self.wait_until_begun()
        return self

    def wait_until_begun(self):
        wait_for(lambda: 'begun' in self.find('body').get_attribute('class'))

    def clean(self):
        """Open the page as somebody who was never here."""
        self.browser.get('about:blank')
        origin = {'origin': self.address.rpartition('/')[0], 'storageTypes': 'local_storage'}
        self.browser.execute_cdp_cmd('Storage.clearDataForOrigin', origin)
        return self.open()

    def script(self, code, *arguments):
        return self.browser.execute_script(code, *arguments)

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector):
        return self.find(selector).get_attribute('textContent')

    def click(self, selector):
        wait_for(self.find(selector).is_enabled)
        self.script('arguments[0].click()', self.find(selector))

    def write(self, text):
        """Replace the text of the editor, by its keyboard."""
        self.find('.cm-content').send_keys(Keys.CONTROL, 'a')
        self.script(
            """const data = new DataTransfer();
            data.setData('text/plain', arguments[0]);
            const pasted = {clipboardData: data, bubbles: true, cancelable: true};
            document.querySelector('.cm-content').dispatchEvent(
              new ClipboardEvent('paste', pasted));""",
            text,
        )

    def editor(self):
        return self.script(
            "return document.querySelector('.cm-content').cmTile.view.state.doc.toString()"
        )

    def set(self, name, value):
        field = self.find(f'#option-{name}')
        field.clear()
        field.send_keys(value)

    def wait(self, seconds=60):
        wait_for(lambda: not self.find('#do-stop').is_enabled(), seconds)

    def run(self):
        self.click('#do-run')
        self.wait()

    def wait_for_download(self, name):
        wait_for((self.downloads / name).is_file)
        return self.downloads / name


@pytest.fixture(scope='module')
def chromium(tmp_path_factory):
    """The page, served with Pyodide, and an exercise and a scenario of its own."""
    if not shutil.which('chromium'):
        pytest.skip('chromium is missing')
    from pyodide_folder import pyodide_folder

    folder = tmp_path_factory.mktemp('site')
    (folder / 'lab.yaml').write_text(RUBRIC)
    (folder / 'law.py').write_text(LAW)
    (folder / 'square.yaml').write_text(SCENARIO)
    downloads = folder / 'downloads'
    for path, content in site(
        ['consensus', 'nav_wp', str(folder / 'lab.yaml')],
        [folder / 'square.yaml'],
        str(pyodide_folder()),
    ).items():
        (folder / 'web' / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / 'web' / path).write_bytes(content)
    asked = []
    with served(folder / 'web', asked) as address, open_browser(1400, 950) as browser:
        allow = {'behavior': 'allow', 'downloadPath': str(downloads)}
        browser.execute_cdp_cmd('Browser.setDownloadBehavior', allow)
        yield Page(browser, address, downloads, asked)


@pytest.fixture
def page(chromium):
    return chromium.clean()


@pytest.mark.nightly
def test_a_law_with_an_error_is_marked_and_mended(page):
    page.write(LAW.replace('poses[1', 'pose[1'))
    page.run()

    assert "name 'pose' is not defined" in page.text('#failures')
    assert page.text('.cm-line.mistake') == '    y = -K * pose[1, robotNo - 1]'
    assert page.text('#run-outcome') != 'complete'

    page.write(LAW)
    page.run()
    assert page.text('#run-title') == 'my_consensus, 8 robots'
    assert page.text('#run-outcome') == 'complete'
    assert page.browser.find_elements(By.CSS_SELECTOR, '.mistake, #failures > *') == []
    assert 'least separation' in page.text('#metrics')
    assert 'hello <b>bold</b>' in page.text('#printed')
    assert page.browser.find_elements(By.CSS_SELECTOR, '#printed b') == []


@pytest.mark.nightly
def test_a_script_that_does_not_load_is_marked(page):
    page.write('x = 1\ny = =\n')
    page.run()

    assert 'SyntaxError' in page.text('#problem')
    assert page.text('.cm-line.mistake') == 'y = ='


@pytest.mark.nightly
def test_the_run_is_played_and_scrubbed(page):
    page.write(LAW)
    page.set('nb_robots', '3')
    page.set('duration', '10')
    page.find('#set').send_keys('K=0.1')
    page.run()
    page.script(
        """const bar = document.getElementById('bar');
        bar.value = 5;
        bar.dispatchEvent(new Event('input'));"""
    )

    assert page.text('#now') == 't = 5.0 s'
    assert page.script('return page.robots.length') == 3
    moved = page.script('return Math.hypot(page.robots[0].x[50], page.robots[0].y[50])')
    page.script("document.getElementById('set').value = 'K=2'")
    page.run()
    assert page.script('return Math.hypot(page.robots[0].x[50], page.robots[0].y[50])') < moved
    page.click('#do-plots')
    page.wait()
    assert page.script("return document.querySelectorAll('#plots img').length") > 1


@pytest.mark.nightly
def test_an_exercise_is_checked_with_points_and_a_hint(page):
    law = ALGORITHMS.file('consensus').read_text().replace('K = 0.5', 'K = 1')
    Select(page.find('#source')).select_by_value('exercise:consensus')
    page.write(law)
    page.click('#do-check')
    page.wait(120)

    assert 'of 10 points' in page.text('.score')
    assert 'as if K were 1, not 0.5' in page.text('#check-marks .note')
    assert page.find('#check-marks img').get_attribute('src').startswith('data:image/png')


@pytest.mark.nightly
def test_a_rubric_shows_its_visible_part_only(page):
    Select(page.find('#source')).select_by_value('rubric:lab')
    page.write(ALGORITHMS.file('consensus').read_text())
    page.click('#do-check')
    page.wait(120)

    assert page.text('.score') == '2 of 2 points', page.text('#problem')


@pytest.mark.nightly
def test_a_scenario_is_run(page):
    page.open('#scenario=square')
    assert page.editor() == LAW
    assert page.find('#option-loss').get_attribute('value') == '0.5'
    page.run()

    assert page.script('return page.robots.length') == 4


@pytest.mark.nightly
def test_a_run_leaves_the_page_as_files(page, tmp_path):
    page.write(LAW)
    page.set('duration', '5')
    page.run()
    stem = page.find('#file-name').get_attribute('value').removesuffix('.py')
    page.click('#save-law')
    assert page.wait_for_download(f'{stem}.py').read_text() == LAW

    page.click('#save-run')
    page.wait()
    zipfile.ZipFile(page.wait_for_download(f'{stem}_run.zip')).extractall(tmp_path)
    assert Run.load(tmp_path / 'run').inputs[0].contents == [LAW.encode()]

    page.script("document.getElementById('report-name').value = '<img src=x onerror=alert(1)>'")
    page.click('#save-report')
    page.wait(120)
    html = page.wait_for_download(f'{stem}.html').read_text()
    assert '&lt;img src=x onerror=alert(1)&gt;' in html
    assert '<b>bold' not in html


@pytest.mark.nightly
def test_a_reload_keeps_text_and_settings(page):
    page.write(LAW)
    page.set('nb_robots', '5')
    page.browser.refresh()
    page.wait_until_begun()

    assert page.editor() == LAW
    assert page.find('#option-nb_robots').get_attribute('value') == '5'
    assert [*page.script('return Object.keys(localStorage)')] == ['setcmas site /']


def linked(page):
    page.click('#copy-link')
    wait_for(lambda: page.find('#link-text').get_attribute('value'))
    return '#' + page.find('#link-text').get_attribute('value').partition('#')[2]


@pytest.mark.nightly
def test_a_link_brings_a_law_but_neither_runs_nor_replaces_unasked(page):
    page.write(LAW + '# a stranger\n')
    page.set('nb_robots', '6')
    fragment = linked(page)
    assert len(fragment) < 1000

    page.clean().open(fragment)  # without own text
    assert page.editor() == LAW + '# a stranger\n'
    assert page.find('#option-nb_robots').get_attribute('value') == '6'
    wait_for(lambda: page.find('#do-run').is_enabled())
    assert 'empty' in page.find('#results').get_attribute('class')

    page.write(LAW + '# mine\n')
    page.open(fragment)
    assert page.editor() == LAW + '# mine\n'
    assert 'Replace your text' in page.text('#question-text')
    page.click('#hold')
    assert page.editor() == LAW + '# mine\n'
    page.open(fragment).click('#replace')
    assert page.editor() == LAW + '# a stranger\n'
    assert page.script('return location.hash') == ''


@pytest.mark.nightly
@pytest.mark.parametrize(
    'fragment', ['#code=x', '#code=', '#code=eJzLSM3JyQcABiwCFQ', '#law=nothing']
)
def test_a_damaged_link_is_refused(page, fragment):
    page.open(fragment)

    assert page.text('#problem')
    assert 'def control' in page.editor()


@pytest.mark.nightly
def test_a_law_that_is_too_long_for_a_link_is_refused(page):
    page.write(
        LAW
        + '\n'.join(
            f'# {hashlib.sha256(bytes([k % 256, k // 256])).hexdigest()}' for k in range(400)
        )
    )
    page.click('#copy-link')
    wait_for(lambda: page.text('#problem'))

    assert 'too long for a link' in page.text('#problem')


@pytest.mark.nightly
def test_a_law_that_hangs_is_stopped_by_hand_and_by_itself(page):
    page.write(LAW.replace('x =', 'while t > 1: pass\n    x ='))
    page.click('#do-run')
    wait_for(lambda: 'Running: t' in page.text('#status'))
    page.click('#do-stop')
    page.wait()
    assert page.text('#problem') == ''

    page.run()  # in a new worker; Python ends the call itself
    assert 'control has not returned for 10 s' in page.text('#problem')
    assert page.text('.cm-line.mistake').strip() == 'while t > 1: pass'
    page.write(LAW)
    page.run()
    assert page.text('#run-outcome') == 'complete'


@pytest.mark.nightly
def test_a_call_that_never_comes_back_to_python_is_ended(page):
    page.write('import time\n' + LAW.replace('x =', 'time.sleep(1000 * (t > 1))\n    x ='))
    page.run()

    assert 'has not answered for 15 s' in page.text('#problem')


ATTACK = """
import js

def attempt(name, what):
    try:
        print(f'{name}: {what()}')
    except BaseException as error:
        print(f'{name}: refused')

def request(method, address):
    call = js.XMLHttpRequest.new()
    call.open(method, address, False)
    call.send()
    return call.status

SERVER = 'http://127.0.0.1:PORT/index.html?stolen='
if __name__.endswith('_1'):
    attempt('origin', lambda: js.self.origin)
    attempt('document', lambda: js.document)
    attempt('parent', lambda: js.self.parent.document)
    attempt('localStorage', lambda: js.localStorage)
    attempt('indexedDB', lambda: js.indexedDB.open('x'))
    attempt('caches', lambda: js.caches.keys())
    attempt('eval', lambda: js.eval('1 + 1'))
    attempt('import', lambda: js.importScripts(SERVER + 'import'))
    attempt('request', lambda: request('GET', SERVER + 'request'))
    attempt('post', lambda: request('POST', SERVER + 'post'))
    original = js.Object.getPrototypeOf(js.Object.getPrototypeOf(js.self)).fetch
    attempt('fetch', lambda: original.call(js.self, SERVER + 'fetch') and 'begun')
    attempt('socket', lambda: js.WebSocket.new(SERVER.replace('http', 'ws')) and 'begun')
    attempt('events', lambda: js.EventSource.new(SERVER + 'events') and 'begun')
    attempt('worker', lambda: js.Worker.new(SERVER + 'worker') and 'begun')
    channel = js.BroadcastChannel.new('x')
    attempt('channel', lambda: channel.postMessage('stolen') or 'begun')
"""


@pytest.mark.nightly
def test_a_script_reaches_nothing_outside_its_worker(page):
    port = page.address.rpartition(':')[2].partition('/')[0]
    page.script(
        """window.heard = [];
        window.listening = new BroadcastChannel('x');
        listening.onmessage = message => heard.push(message.data);"""
    )
    page.write(ATTACK.replace('PORT', port) + LAW)
    page.run()
    printed = [line.split(': ', 2)[1:] for line in page.text('#printed').splitlines()]
    found = dict(one for one in printed if len(one) == 2)
    page.script(
        """fetch('index.html?own');  // after all attempts
        new BroadcastChannel('x').postMessage('own');"""
    )
    wait_for(lambda: '/index.html?own' in page.asked and page.script('return heard.length'))

    assert found.pop('origin') == 'null', page.text('#problem')
    begun = {name for name in found if found[name] == 'begun'}  # but reaches nothing
    assert begun >= {'fetch', 'socket', 'channel'}
    found = {name: what for name, what in found.items() if name not in begun}
    assert set(found.values()) == {'refused'}, found
    assert len(found) + len(begun) == 14
    assert [path for path in page.asked if 'stolen' in path] == []
    assert page.script('return heard') == ['own']
    assert page.text('#run-outcome') == 'complete'


@pytest.mark.nightly
def test_the_editor_can_be_left_by_keyboard(page):
    wait_for(page.find('#do-run').is_enabled)
    before = page.editor()
    page.find('.cm-content').send_keys(Keys.TAB)
    indented = page.editor()
    page.find('.cm-content').send_keys(Keys.ESCAPE, Keys.TAB)

    assert len(indented) == len(before) + 4
    assert page.editor() == indented
    assert page.script('return document.activeElement.id') == 'do-run'
    assert page.find('.cm-content').get_attribute('aria-label') == 'Your script, in Python'


@pytest.mark.nightly
def test_it_fits_a_phone(page):
    metrics = {'width': 390, 'height': 844, 'deviceScaleFactor': 2, 'mobile': True}
    page.browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', metrics)
    try:
        page.open().run()
        assert page.script('return document.documentElement.scrollWidth') <= 390
        assert page.find('#do-run').rect['height'] >= 38
    finally:
        page.browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})
