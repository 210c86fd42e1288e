import csv
import subprocess
import sys

import pytest
from browser import open_browser, open_page, wait_for
from processes import refuses
from report_pages import HOSTILE, LAW, Page
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from launch_scripts.cli import main
from setcmas_tools.offline.offline_simulation import simulate

SIZES = [(1366, 768), (1920, 1080), (390, 844)]


@pytest.fixture(scope='session')
def runs(tmp_path_factory):
    """A folder with a run of a law that fails and one of a law that does not."""
    folder = tmp_path_factory.mktemp('report')
    (folder / 'law.py').write_text(LAW)
    for algo, name in ((folder / 'law.py', 'failed'), ('consensus', 'well')):
        simulate(algo, 3, 5.0, delay=0.3, warn=lambda _: None).save(folder / name)
    return folder


@pytest.fixture(scope='session')
def folder(runs):
    """The folder of the runs, with a report of the one that fails."""
    assert main(['report', str(runs / 'failed'), '-o', str(runs / 'failed.html')]) == 0
    return runs


@pytest.mark.nightly
def test_title_names_and_answers_of_students_are_in_the_page(runs, tmp_path):
    pytest.importorskip('markdown_it')
    page, answers = tmp_path / 'page.html', tmp_path / 'answers.md'
    answers.write_text(f'# Question 1\n\n$x^2$ {HOSTILE}')
    given = ['--title=Lab <2>', '--name=Ada & Alan', f'--answers={answers}']
    assert main(['report', str(runs / 'well'), '-o', str(page), *given]) == 0

    found = Page(page.read_text())
    texts = [('title', 'Lab <2>'), ('h1', 'Lab <2>'), ('p', 'Ada & Alan'), ('h2', 'Question 1')]
    assert {*texts} <= {*found.text}
    assert [tag for tag, _ in found.elements].count('h1') == 1
    assert HOSTILE in found.shown


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['nothing'], "there is no 'nothing'; it must be the folder of a run"),
        (['well', '-o', 'out.pdf'], "the page 'out.pdf' must end with .html"),
        (['well', '-o', 'no/out.html'], "there is no folder 'no'; create it"),
        (['.'], "there is no fleet.csv in '.'"),
    ],
)
def test_mistakes_are_reported_in_one_line(runs, arguments, message):
    refuses('report', *arguments, message=message, cwd=runs)


VIEW_WITHOUT_ROS = """
import sys
sys.modules['rclpy'] = None
from setcmas_tools.page import server
server.show_page = lambda text, _: print(text.count('<canvas'))
from launch_scripts.cli import main
sys.exit(main(['view', sys.argv[1]]))
"""


def test_a_finished_run_is_viewed_without_ros(runs):
    command = [sys.executable, '-c', VIEW_WITHOUT_ROS, runs / 'well']
    done = subprocess.run(command, capture_output=True, text=True)

    assert (done.returncode, done.stdout) == (0, '2\n'), done.stderr


@pytest.fixture(scope='module')
def browser(needs_chromium):
    with open_browser(1366, 768) as opened:
        opened.execute_cdp_cmd('Network.enable', {})
        yield opened


def show(browser, folder, place=''):
    browser.get('about:blank')  # nothing is left from another test
    open_page(browser, f'{(folder / "failed.html").as_uri()}{place}')


def resized(browser, width, height):
    size = {'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': width < 500}
    browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', size)


def numbers(browser):
    """Return the numbers in the rows of robots, as they are shown."""
    rows = browser.execute_script(
        "return [...document.querySelectorAll('#robots tr')].map(row => row.innerText)"
    )
    return [row.replace('\N{MINUS SIGN}', '-').split() for row in rows]


@pytest.mark.nightly
def test_a_browser_shows_the_run_at_any_time(folder, browser):
    text = (folder / 'failed' / 'csv' / 'fleet.csv').read_text()
    table = list(csv.DictReader(text.splitlines()))
    show(browser, folder, '#t=2.3')

    def expect(t):
        assert browser.find_element(By.ID, 'now').text == f't = {t:.1f} s'
        wanted = [row for row in table if abs(float(row['t']) - t) < 1e-6]
        assert len(wanted) == 3
        for shown, row in zip(numbers(browser), wanted, strict=True):
            assert shown[0] == f'tb3_{row["robot"]}'
            for place, name in ((1, 'x'), (2, 'y'), (4, 'v')):
                assert float(shown[place]) == pytest.approx(float(row[name]), abs=6e-4)

    expect(2.3)
    set_bar = (
        "const bar = document.getElementById('bar'); bar.value = arguments[0];"
        "bar.dispatchEvent(new Event('input'))"
    )
    browser.execute_script(set_bar, 4.1)
    expect(4.1)
    keys = browser.find_element(By.TAG_NAME, 'body')
    for key, t in (
        (Keys.ARROW_RIGHT, 4.2),
        (Keys.HOME, 0.0),
        (Keys.ARROW_LEFT, 0.0),
        (Keys.END, 5.0),
    ):
        keys.send_keys(key)
        expect(t)

    buttons = browser.find_elements(By.CSS_SELECTOR, '.note button')
    [jump] = [button for button in buttons if 'robot 3' in button.text]
    jump.click()
    expect(1.2)
    about = browser.find_element(By.ID, 'about').text
    assert f'Its law failed in line 10 of law.py: ValueError: {HOSTILE}' in about
    assert browser.title == 'law, 3 robots'

    page_width = 'return document.documentElement.scrollWidth'
    for width, height in SIZES:
        resized(browser, width, height)
        wait_for(lambda width=width: browser.execute_script(page_width) == width)
    browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})
    fetched = "return performance.getEntriesByType('resource').map(one => one.name)"
    assert not [name for name in browser.execute_script(fetched) if not name.startswith('data:')]
    assert browser.get_log('browser') == []


@pytest.mark.nightly
def test_a_selected_robot_is_described_and_space_plays(folder, browser):
    show(browser, folder)
    browser.find_elements(By.CSS_SELECTOR, '#robots button')[1].click()
    assert browser.find_element(By.ID, 'about').text.startswith('tb3_2\nat (5.000')

    browser.find_element(By.ID, 'plane').send_keys(' ')
    wait_for(lambda: browser.find_element(By.ID, 'now').text == 't = 5.0 s')
    wait_for(lambda: browser.find_element(By.ID, 'play').text == '▶')


_TOO_SMALL = """const controls = document.querySelectorAll('button, select, a, label, #bar');
return [...controls].filter(one => {
  const box = one.getBoundingClientRect();
  return box.width && Math.min(box.width, box.height) < 24;  // WCAG 2.2, 2.5.8
}).map(one => one.outerHTML)"""
_COVERED = """const plane = document.querySelector('#plane').getBoundingClientRect();
return document.querySelector('.zoom').getBoundingClientRect().top < plane.bottom"""


@pytest.mark.nightly
def test_on_a_phone_fingers_hit_every_control_and_none_covers_a_robot(folder, browser):
    resized(browser, 390, 844)
    show(browser, folder)

    assert browser.execute_script(_TOO_SMALL) == []
    assert not browser.execute_script(_COVERED)
    browser.execute_cdp_cmd('Emulation.clearDeviceMetricsOverride', {})


WATCH_PRINT = """
window.addEventListener('beforeprint', () => {
  const plane = document.getElementById('plane'), {width, height} = plane, counts = {};
  const pixels = plane.getContext('2d').getImageData(0, 0, width, height).data;
  for (let k = 0; k < pixels.length; k += 4) {
    const bytes = [...pixels.slice(k, k + 3)].map(one => one.toString(16).padStart(2, '0'));
    const colour = '#' + bytes.join('');
    counts[colour] = (counts[colour] || 0) + 1;
  }
  window.printed = [counts, document.getElementById('now').textContent];
});
"""
SCROLLED = """
return [...document.querySelectorAll('body *')].filter(one => one.offsetParent
  && getComputedStyle(one).overflowX === 'auto').map(one => one.outerHTML.slice(0, 200));
"""


@pytest.mark.nightly
def test_paper_shows_the_paths_of_the_robots_and_no_scroll_bars(folder, browser):
    show(browser, folder)
    browser.execute_script(WATCH_PRINT)
    browser.execute_cdp_cmd('Page.printToPDF', {})

    counts, time = browser.execute_script('return window.printed')
    assert time == 't = 5.0 s'  # at the beginning there would be no trails
    for colour in browser.execute_script('return page.robots.map(robot => robot.colour)'):
        assert counts.get(colour, 0) > 20, colour
    wait_for(lambda: browser.find_element(By.ID, 'now').text == 't = 0.0 s')

    browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {'media': 'print'})
    try:
        assert browser.execute_script(SCROLLED) == []
    finally:
        browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {'media': ''})
