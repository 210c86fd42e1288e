"""Bundles run as their platforms run them: in an environment that has nothing but them."""

import base64
import csv
import hashlib
import io
import json
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest
import yaml
from jsonschema import validate
from platform_schemas import SCHEMAS

from setcmas_tools.grade.rubric import read_rubric, rubric_of_exercise
from setcmas_tools.platforms.autograder import own_wheel
from setcmas_tools.platforms.grade_format import make_bundle

DATA = Path(__file__).parents[2] / 'data'
SUBMISSIONS = yaml.safe_load((DATA / 'platform_submissions.yaml').read_text())
LAW = {'law.py': rubric_of_exercise('consensus').solution.read_text()}
RUBRIC = """
title: Meet
solution: law.py
scenarios:
  - name: two robots
    nb_robots: 2
    duration: 5
    criteria:
      - {name: they take the path, metric: path_error, at_most: 0.05, points: 2.5}
"""
NOTHING = {'PATH': '/usr/sbin:/usr/bin:/sbin:/bin', 'LANG': 'C.UTF-8'}
"""The environment of a container: no virtual environment, no home."""


@pytest.fixture(scope='module')
def rubric(tmp_path_factory):
    """A rubric of a teacher, with the solution in its folder."""
    folder = tmp_path_factory.mktemp('rubric')
    for name, text in (LAW | {'rubric.yaml': RUBRIC}).items():
        (folder / name).write_text(text)
    return read_rubric(folder / 'rubric.yaml')


@pytest.fixture(scope='module')
def image(rubric, tmp_path_factory):
    """The image that Gradescope builds: the folder /autograder after setup.sh."""
    root = tmp_path_factory.mktemp('image') / 'autograder'
    unzipped('gradescope', rubric).extractall(root / 'source')
    (root / 'submission').mkdir()
    offline = {'PIP_NO_DEPS': '1', 'PIP_NO_INDEX': '1', 'AUTOGRADER': str(root)}
    path = f'{Path(sys._base_executable).parent}:{NOTHING["PATH"]}'
    setup = ['bash', root / 'source' / 'setup.sh']
    subprocess.run(setup, env=NOTHING | offline | {'PATH': path}, check=True)
    # Dependencies are taken from where the tests run.
    [site] = (root / 'venv').glob('lib/python*/site-packages')
    (site / 'dependencies.pth').write_text(f'{sysconfig.get_paths()["purelib"]}\n')
    return root


def unzipped(name, rubric):
    return zipfile.ZipFile(io.BytesIO(make_bundle(name, rubric)))


def of_gradescope(root, files, environment=NOTHING):
    """Return results.json of a submission."""
    for place, contents in (('submission', files), ('results', {})):
        for old in (root / place).glob('*'):
            old.unlink()
        for name, text in contents.items():
            (root / place / name).write_text(text)
    run = ['bash', root / 'source' / 'run_autograder']
    subprocess.run(run, env=environment | {'AUTOGRADER': str(root)}, cwd=root, check=False)
    result = json.loads((root / 'results' / 'results.json').read_text())
    validate(result, SCHEMAS['gradescope'])
    return result


def of_coderunner(rubric, folder, answer, path=NOTHING['PATH']):
    """Return what the template prints for an answer, in a folder of the Jobe server."""
    bundle = unzipped('coderunner', rubric)
    (folder / 'rubric.zip').write_bytes(bundle.read('rubric.zip'))
    answer = answer.replace('\\', '\\\\').replace('"', '\\"')  # as Twig's e("py")
    template = bundle.read('template.py').decode()
    (folder / 'prog.py').write_text(template.replace('{{ STUDENT_ANSWER | e("py") }}', answer))
    command = ['prlimit', '--nproc=500', '--fsize=20000000', sys.executable, 'prog.py']
    environment = NOTHING | {'PATH': path}
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True)
    return json.loads(done.stdout)


@pytest.mark.nightly
def test_gradescope_gives_all_points_to_the_solution(image):
    result = of_gradescope(image, LAW)

    assert (result['score'], [test['score'] for test in result['tests']]) == (2.5, [2.5])


@pytest.mark.nightly
@pytest.mark.parametrize('name', SUBMISSIONS)
def test_gradescope_gets_results_of_every_submission(image, name):
    result = of_gradescope(image, SUBMISSIONS[name]['files'])

    assert result['score'] == 0
    assert SUBMISSIONS[name]['says'] in result['output'] + result['tests'][0]['output']


@pytest.mark.nightly
@pytest.mark.parametrize('name', [name for name, one in SUBMISSIONS.items() if one['files']])
def test_coderunner_gets_results_of_every_answer(image, rubric, tmp_path, name):
    path = f'{image / "venv" / "bin"}:{NOTHING["PATH"]}'
    result = of_coderunner(rubric, tmp_path, SUBMISSIONS[name]['files']['law.py'], path)

    validate(result, SCHEMAS['coderunner'])
    assert result['fraction'] == 0
    assert SUBMISSIONS[name]['says'] in result['prologuehtml'] + str(result['testresults'])


@pytest.mark.nightly
def test_coderunner_gives_all_points_to_the_solution(image, rubric, tmp_path):
    path = f'{image / "venv" / "bin"}:{NOTHING["PATH"]}'

    assert of_coderunner(rubric, tmp_path, LAW['law.py'], path)['fraction'] == 1


def test_a_bundle_that_cannot_grade_says_so_in_valid_results(rubric, tmp_path):
    unzipped('gradescope', rubric).extractall(tmp_path / 'source')  # without setup.sh
    (tmp_path / 'submission').mkdir()
    (tmp_path / 'coderunner').mkdir()

    result = of_gradescope(tmp_path, LAW)
    assert result['output'].startswith('This was not graded: the autograder failed')
    result = of_coderunner(rubric, tmp_path / 'coderunner', LAW['law.py'])
    assert 'No such file or directory: &#x27;setcmas&#x27;' in result['prologuehtml']
    assert result['fraction'] == 0


def test_the_wheel_has_all_packages_with_their_data_and_a_right_record():
    name, content = own_wheel()
    wheel = zipfile.ZipFile(io.BytesIO(content))
    stem = name.removesuffix('-py3-none-any.whl')
    record = wheel.read(f'{stem}.dist-info/RECORD').decode()
    rows = {path: digest for path, digest, _ in csv.reader(record.splitlines())}

    assert rows.keys() == set(wheel.namelist())
    assert rows.keys() >= {
        'launch_scripts/cli.py',
        'setcmas_ctrl/exercises/consensus.yaml',
        'setcmas_tools/grade/templates/student.html',
        'setcmas_tools/platforms/templates/gradescope/setup.sh.in',
        'setcmas_tools/page/templates/base.css',
        'setcmas_tools/page/templates/player.js',
    }
    for path in (f'{stem}.dist-info/METADATA', 'setcmas_simu/errors.py'):
        digest = base64.urlsafe_b64encode(hashlib.sha256(wheel.read(path)).digest())
        assert rows[path] == f'sha256={digest.decode().rstrip("=")}'
    points = wheel.read(f'{stem}.dist-info/entry_points.txt').decode()
    assert 'gradescope = setcmas_tools.platforms.gradescope:GRADESCOPE' in points
    assert own_wheel() == (name, content)
