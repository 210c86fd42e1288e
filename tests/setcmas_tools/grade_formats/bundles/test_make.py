"""Bundles for platforms: what is in them, and the one of Gradescope at work."""

import io
import json
import os
import shutil
import subprocess
import sysconfig
import zipfile
from dataclasses import replace

import pytest
from jsonschema import validate
from platform_schemas import SCHEMAS

from setcmas_simu.errors import SetcmasError
from setcmas_tools.grade_formats.bundles.make import make_bundle
from setcmas_tools.grading.rubric import rubric_of_exercise

RUBRIC = rubric_of_exercise('consensus')


def bundle(name, options='', rubric=RUBRIC):
    return zipfile.ZipFile(io.BytesIO(make_bundle(name, rubric, options)))


def test_the_zip_of_gradescope_has_its_scripts_at_the_root_and_they_can_be_executed():
    archive = bundle('gradescope', '--trust')

    for name in ('setup.sh', 'run_autograder'):
        assert archive.getinfo(name).external_attr >> 16 & 0o777 == 0o755
    assert '--trust' in archive.read('run_autograder').decode()
    assert archive.read('rubric/consensus.yaml') == RUBRIC.file.read_bytes()


@pytest.mark.parametrize(
    ('name', 'paths'),
    [
        ('gradescope', {'setup.sh', 'run_autograder', 'rubric/consensus.yaml'}),
        ('coderunner', {'template.py', 'rubric.zip', 'README.txt'}),
    ],
)
def test_bundles_have_what_their_platform_looks_for_and_run_as_scripts(name, paths):
    archive = bundle(name)
    wheels = {path for path in archive.namelist() if path.endswith('.whl')}

    assert len(wheels) == 1
    assert {*archive.namelist()} - wheels == paths
    for path in paths:
        text = archive.read(path)
        if path.endswith('.py'):
            compile(text, path, 'exec')
        elif path.endswith('.json'):
            json.loads(text)
        elif text.startswith(b'#!'):
            subprocess.run(['bash', '-n'], input=text, check=True)


def test_a_bundle_is_the_same_twice():
    assert make_bundle('gradescope', RUBRIC) == make_bundle('gradescope', RUBRIC)


def test_modules_that_the_solution_imports_are_in_the_bundle(tmp_path):
    for name, text in {'rubric.yaml': '', 'law.py': 'import gains', 'gains.py': 'K = 1'}.items():
        (tmp_path / name).write_text(text)
    rubric = replace(RUBRIC, file=tmp_path / 'rubric.yaml', solution=tmp_path / 'law.py')

    assert bundle('gradescope', rubric=rubric).read('rubric/gains.py') == b'K = 1'


def test_files_of_a_rubric_that_lie_elsewhere_are_told(tmp_path):
    law = tmp_path / 'law.py'
    law.touch()

    with pytest.raises(SetcmasError, match=r"law.py' must be in the folder of the rubric"):
        make_bundle('gradescope', replace(RUBRIC, solution=law))
    with pytest.raises(SetcmasError, match='must be one of coderunner, gradescope'):
        make_bundle('junit', RUBRIC)


@pytest.mark.nightly
def test_gradescope_gets_results_from_what_was_uploaded(tmp_path):
    root = tmp_path / 'autograder'
    bundle('gradescope').extractall(root / 'source')
    (root / 'submission').mkdir()
    shutil.copy(RUBRIC.solution, root / 'submission' / 'my_law.py')
    offline = {'PIP_NO_DEPS': '1', 'PIP_NO_INDEX': '1', 'AUTOGRADER': str(root)}

    subprocess.run(['bash', root / 'source' / 'setup.sh'], env=os.environ | offline, check=True)
    # Dependencies are taken from where the tests run.
    [site] = (root / 'venv').glob('lib/python*/site-packages')
    packages = sysconfig.get_paths()['purelib']
    (site / 'dependencies.pth').write_text(f'{packages}\n')
    run = ['bash', root / 'source' / 'run_autograder']
    subprocess.run(run, env=os.environ | offline, cwd=root, check=True)

    result = json.loads((root / 'results' / 'results.json').read_text())
    validate(result, SCHEMAS['gradescope'])
    assert result['score'] == RUBRIC.max_score
