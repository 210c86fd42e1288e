"""The page of `setcmas site`, in Chromium with Pyodide."""

import zipfile

import numpy as np
import pytest
from browser import open_browser, wait_for
from page_of_laws import LAW, RUBRIC, Page
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select
from served_folder import served

from setcmas_ctrl.laws.script_loader import ALGORITHMS
from setcmas_tools import simulate
from setcmas_tools.page.site_folder import site
from setcmas_tools.plots.plot import plots_of
from setcmas_tools.run.run import Run

pytestmark = pytest.mark.nightly


def write(files, folder):
    for path, content in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)


@pytest.fixture(scope='module')
def chromium(needs_chromium, tmp_path_factory):
    """The page, served with Pyodide, and an exercise of its own."""
    from pyodide_folder import pyodide_folder

    folder = tmp_path_factory.mktemp('site')
    (folder / 'lab.yaml').write_text(RUBRIC)
    downloads = folder / 'downloads'
    rubrics = ['consensus', 'nav_wp', str(folder / 'lab.yaml')]
    write(site(rubrics, pyodide_folder()), folder / 'web')
    asked = []
    with served(folder / 'web', asked) as address, open_browser(1400, 950) as browser:
        allow = {'behavior': 'allow', 'downloadPath': str(downloads)}
        browser.execute_cdp_cmd('Browser.setDownloadBehavior', allow)
        yield Page(browser, address, downloads, asked)


@pytest.fixture
def page(chromium):
    return chromium.clean()


def test_a_law_with_an_error_is_marked_and_mended(page):
    page.write('x = 1\ny = =\n')
    page.run()
    assert 'SyntaxError' in page.text('#problem')
    assert page.text('.cm-line.mistake') == 'y = ='

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
    assert 'm apart at the end' in page.text('#metrics')
    assert 'hello <b>bold</b>' in page.text('#printed')
    assert page.browser.find_elements(By.CSS_SELECTOR, '#printed b') == []


def test_exercises_and_rubrics_are_checked_with_points_and_a_hint(page):
    law = ALGORITHMS.file('consensus').read_text().replace('K = 0.5', 'K = 1')
    Select(page.find('#source')).select_by_value('exercise:consensus')
    page.write(law)
    page.click('#do-check')
    page.wait()

    assert 'of 10 points' in page.text('.score')
    assert 'as if K were 1, not 0.5' in page.text('#check-marks .note')
    assert page.find('#check-marks img').get_attribute('src').startswith('data:image/png')

    page.clean()  # a rubric shows its visible part only
    Select(page.find('#source')).select_by_value('rubric:lab')
    page.write(ALGORITHMS.file('consensus').read_text())
    page.click('#do-check')
    page.wait()

    assert page.text('.score') == '2 of 2 points', page.text('#problem')


def test_a_run_leaves_the_page_as_files(page, tmp_path):
    page.write(LAW)
    for name, value in (('duration', '5'), ('loss', '0.2'), ('delay', '0.2')):
        page.set(name, value)
    page.script("document.getElementById('option-noise').value = '0.01'")
    page.find('#set').send_keys('K=0.1')
    page.run()
    stem = page.find('#file-name').get_attribute('value').removesuffix('.py')
    page.click('#save-law')
    assert page.wait_for_download(f'{stem}.py').read_text() == LAW

    page.click('#save-run')
    page.wait()
    zipfile.ZipFile(page.wait_for_download(f'{stem}_run.zip')).extractall(tmp_path)
    loaded = Run.load(tmp_path / 'run')
    assert loaded.inputs[0].contents == [LAW.encode()]
    law = next((tmp_path / 'run').rglob('my_*.py'))
    here = simulate(str(law), 8, 5.0, loss=0.2, delay=0.2, noise=0.01, set={'K': 0.1})
    assert np.allclose(loaded.poses, here.poses, rtol=0, atol=1e-9)
    assert loaded.info.origin.host['system'].startswith('Emscripten')
    assert str(loaded.metrics()).splitlines()[-1] in page.text('#metrics')

    page.script("document.getElementById('report-name').value = '<img src=x onerror=alert(1)>'")
    page.click('#save-report')
    page.wait()
    html = page.wait_for_download(f'{stem}.html').read_text()
    assert '&lt;img src=x onerror=alert(1)&gt;' in html
    assert '<b>bold' not in html
    assert html.count('data:image/png') == len(plots_of(loaded))


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


@pytest.mark.parametrize('fragment', ['#code=eJzLSM3JyQcABiwCFQ', '#law=nothing'])
def test_a_damaged_link_is_refused(page, fragment):
    page.open(fragment)

    assert page.text('#problem')
    assert 'def control' in page.editor()


def test_a_law_that_hangs_is_stopped_by_hand_and_by_itself(page):
    page.write(LAW.replace('x =', 'while t > 1: pass\n    x ='))
    page.click('#do-run')
    wait_for(lambda: 'Running: t' in page.text('#status'))
    page.click('#do-stop')
    page.wait()
    assert page.text('#problem') == ''

    page.write(LAW.replace('x =', 'import os; os._exit(1)\n    x ='))
    page.run()  # in a new worker
    assert 'terminated with exit(1)' in page.text('#problem')

    page.write(LAW.replace('x =', 'while t > 1: pass\n    x ='))
    page.run()
    assert ', line 7: this loop has not ended within 15 s after t = 1.' in page.text('#problem')
    assert page.text('.cm-line.mistake') == '    while t > 1: pass'


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


def test_it_fits_a_phone(page):
    metrics = {'width': 390, 'height': 844, 'deviceScaleFactor': 2, 'mobile': True}
    page.browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', metrics)
    try:
        page.open().run()
        top = "return document.getElementById('results').getBoundingClientRect().top"
        assert abs(page.script(top)) < 50  # the robots are in view
        page.click('#do-plots')
        page.wait()
        assert page.script('return document.documentElement.scrollWidth') <= 390
        assert page.find('#do-run').rect['height'] >= 38
    finally:
        page.browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})


def test_without_pyodide_the_page_says_so_once(needs_chromium, tmp_path, monkeypatch):
    monkeypatch.setattr('setcmas_tools.page.site_folder.CDN', 'http://127.0.0.1:9/')
    write(site(['consensus']), tmp_path)
    with served(tmp_path) as address, open_browser(1280, 900) as browser:
        page = Page(browser, address, tmp_path, []).open()
        wait_for(lambda: page.text('#problem'))

        assert 'cannot be loaded: there is no network' in page.text('#problem')
        assert page.text('#status') == 'Stopped: see the message.'
        page.run()
        assert 'cannot be loaded: there is no network' in page.text('#problem')
        assert page.text('#status') == 'Stopped: see the message.'
