"""Bundles carry the packages whose plugins their rubric uses."""

import io
import shutil
import sys
import zipfile
from pathlib import Path

import pytest

from setcmas_simu import plugins
from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade.rubric import read_rubric
from setcmas_tools.platforms.grade_format import make_bundle

PLUGIN = Path(__file__).parents[2] / 'plugin'
ENTRIES = """
[setcmas.metrics]
excursion = example_lab.excursion:excursion
[setcmas.algorithms]
spiral = example_lab.spiral
"""
RUBRIC = 'scenarios: [{name: one, criteria: [{metric: %s, at_most: 1}]}]\n'


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder with an installed package of plugins."""
    site = tmp_path / 'site'
    shutil.copytree(PLUGIN / 'example_lab', site / 'example_lab')
    metadata = site / 'example_lab-0.3.dist-info'
    metadata.mkdir()
    (metadata / 'METADATA').write_text('Metadata-Version: 2.1\nName: example-lab\nVersion: 0.3\n')
    (metadata / 'entry_points.txt').write_text(ENTRIES)
    monkeypatch.syspath_prepend(site)
    for cached in (plugins._entries, plugins._plugins):
        cached.cache_clear()
    yield site
    for cached in (plugins._entries, plugins._plugins):
        cached.cache_clear()
    for name in [name for name in sys.modules if name.partition('.')[0] == 'example_lab']:
        del sys.modules[name]


def rubric(tmp_path, text):
    file = tmp_path / 'lecture' / 'rubric.yaml'
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)
    return read_rubric(file)


def bundle(name, *given):
    return zipfile.ZipFile(io.BytesIO(make_bundle(name, rubric(*given))))


@pytest.mark.parametrize(
    'text', [RUBRIC % 'excursion', 'solution: spiral\n' + RUBRIC % 'path_error']
)
def test_packages_of_metrics_and_solutions_are_carried_and_installed(site, tmp_path, text):
    wheel = 'example_lab-0.3-py3-none-any.whl'
    gradescope, coderunner = (
        bundle(name, tmp_path, text) for name in ('gradescope', 'coderunner')
    )

    for archive, script in ((gradescope, 'setup.sh'), (coderunner, 'README.txt')):
        assert f'[grade]" ./{wheel}' in archive.read(script).decode().replace("'", '"')
        inside = zipfile.ZipFile(io.BytesIO(archive.read(wheel)))
        assert {'example_lab/excursion.py', 'example_lab-0.3.dist-info/RECORD'} <= {
            *inside.namelist()
        }
    rubrics = zipfile.ZipFile(io.BytesIO(coderunner.read('rubric.zip')))
    assert rubrics.namelist() == ['rubric/rubric.yaml']
    made = bundle('check', tmp_path, text).read('rubric_check/rubric.yaml').decode()
    assert '# It needs the packages: example-lab' in made or 'references/1' in made


def test_packages_that_a_rubric_does_not_use_stay_away(site, tmp_path):
    names = bundle('gradescope', tmp_path, RUBRIC % 'disagreement').namelist()

    assert len([name for name in names if name.endswith('.whl')]) == 1


def test_a_package_with_compiled_parts_is_refused_in_a_line(site, tmp_path):
    (site / 'example_lab' / 'fast.so').touch()

    with pytest.raises(SetcmasError) as error:
        bundle('gradescope', tmp_path, RUBRIC % 'excursion')

    assert "uses package 'example-lab', which the bundle cannot carry" in str(error.value)
    assert '\n' not in str(error.value)
