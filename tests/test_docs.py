"""The site: it builds without a warning, fetches nothing, and its generated parts are those of the
code."""

import fcntl
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
GENERATORS = ROOT / 'docs' / 'generators'
pytest.importorskip('mkdocs')


@pytest.fixture(scope='session')
def site(tmp_path_factory, worker_id):
    """Build the site, once for all workers."""
    base = tmp_path_factory.getbasetemp()
    folder = (base if worker_id == 'master' else base.parent) / 'site'
    command = [sys.executable, '-m', 'mkdocs', 'build', '--strict', '-q', '-d', str(folder)]
    with folder.with_suffix('.lock').open('w') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            build = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
            assert build.returncode == 0, build.stderr
    return folder


@pytest.mark.nightly
def test_it_fetches_nothing_from_the_network(site):
    for page in site.rglob('*.html'):
        fetched = re.findall(
            r'<(?:script|link|img|iframe)\b[^>]*(?:src|href)="(.*?)"', page.read_text()
        )
        assert [url for url in fetched if url.startswith(('http', '//'))] == [], page.name


@pytest.mark.usefixtures('needs_chromium')
@pytest.mark.nightly
def test_pages_fit_a_phone(site):
    from browser import open_browser, open_page

    width = 390
    too_wide = []
    with open_browser(width, 844) as browser:
        screen = {'width': width, 'height': 844, 'deviceScaleFactor': 1, 'mobile': True}
        browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', screen)
        for page in set(site.rglob('*.html')) - {site / 'try' / 'sandbox.html'}:  # hidden frame
            open_page(browser, page.as_uri())
            if browser.execute_script('return document.documentElement.scrollWidth') > width:
                too_wide.append(page.name)
    assert too_wide == []


@pytest.mark.nightly
def test_each_law_and_exercise_can_be_tried(site):
    catalogue = json.loads((site / 'try' / 'catalogue.json').read_text())
    for page, kind in (('atlas', 'law'), ('exercises', 'exercise')):
        linked = re.findall(
            f'href="try/index.html#{kind}=(\\w+)"', (site / f'{page}.html').read_text()
        )
        keys = [one['key'].partition(':') for one in catalogue['sources']]
        known = [name for of, _, name in keys if of == kind]
        assert sorted(linked) == sorted(known), page
    assert 'href="try/index.html"' in (site / 'index.html').read_text()


@pytest.mark.nightly
def test_formulas_are_mathml(site):
    page = (site / 'control_scripts.html').read_text()

    assert page.count('<math') >= 10
    assert 'arithmatex' not in page


@pytest.mark.nightly
def test_every_page_is_in_the_navigation(site):
    home = (site / 'index.html').read_text()
    for page in (ROOT / 'docs').rglob('*.md'):
        assert f'href="{page.relative_to(ROOT / "docs").with_suffix(".html")}"' in home


def test_generated_parts_are_up_to_date(monkeypatch):
    """`python docs/generators/generate.py` brings them up to date."""
    monkeypatch.syspath_prepend(GENERATORS)
    import generate

    stale = [
        path.name for path, text in generate.generated_files().items() if path.read_text() != text
    ]
    assert stale == []


def test_changelogs_of_packages_are_read_by_bloom(monkeypatch):
    changelog = pytest.importorskip('catkin_pkg.changelog')
    monkeypatch.syspath_prepend(GENERATORS)
    import changelog_page

    text = changelog_page.text(
        'setcmas_simu',
        '# Changelog\n\n## 0.2.0, unreleased\n\n- New\n\n'
        '## 0.1.0, 2026-11-30\n\n- A `-p x_0:=2` and\n  [more](docs/ros.md).\n- B*\n',
    )
    read = changelog.Changelog('setcmas_simu')
    changelog.populate_changelog_from_rst(read, text)

    assert 'Forthcoming\n-----------\n* New\n' in text
    assert str(read).splitlines()[1:] == [
        '  0.1.0 (2026-11-30 00:00:00):',
        '    * A ``-p x_0:=2`` and more.',
        '    * B*',
    ]


def test_the_citation_names_the_version_and_the_paper():
    from setcmas_simu import __version__

    citation = yaml.safe_load((ROOT / 'CITATION.cff').read_text())

    assert {'cff-version', 'message', 'title', 'authors'} <= citation.keys()
    assert citation['version'] == __version__
    assert citation['authors'] == [{'name': 'setcmas developers'}]
    (paper,) = citation['references']
    assert paper['authors'][0]['family-names'] == 'Bertrand'
    assert (paper['year'], paper['conference']['name']) == (2024, 'European Control Conference')
