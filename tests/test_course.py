"""The practical sessions, done from their pages with the model solutions."""

import re
import shlex
from pathlib import Path

import pytest
from processes import PATIENT_LAB, run_here

from setcmas_ctrl.laws.script_loader import ALGORITHMS

COURSE = Path(__file__).parents[1] / 'docs' / 'course'
FIGURES = re.compile(r'^\| `setcmas (offline [^`]*)` \| (`.*`) \|$', re.M)
CONDITION = ('return True', 'return np.linalg.norm(pos - last_pos) > THRESHOLD')


@pytest.fixture(params=range(1, 7))
def session(request, tmp_path):
    """Lay the folder of a session, with the model solutions in place of the exercises."""
    run_here('new', '--session', str(request.param), cwd=tmp_path)
    folder = tmp_path / f'session_{request.param}'
    for exercise in folder.glob('my_*.py'):
        name = exercise.stem.removeprefix('my_')
        if name == 'ctc':
            exercise.write_text(exercise.read_text().replace(*CONDITION))
        else:
            solution = ALGORITHMS.file(name).read_text()
            exercise.write_text(f'{solution}\nexercise = {name!r}\n')
    return folder


@pytest.mark.nightly
def test_commands_print_the_figures_of_the_lecturers_page(session):
    found = FIGURES.findall((COURSE / f'{session.name}_lecturer.md').read_text())
    assert found
    for command, figures in found:
        words = [*shlex.split(command), '--no-plots', '--overwrite', '-o', 'out']
        done = run_here(*words, cwd=session)
        printed = done.stdout + done.stderr
        for figure in re.findall('`([^`]*)`', figures):
            assert figure in printed, command


@pytest.mark.nightly
@pytest.mark.ros
def test_every_command_of_the_students_page_works(session, domain):
    blocks = re.findall(r'^```sh\n(.*?)^```', (session / 'session.md').read_text(), re.S | re.M)
    lines = [shlex.split(line)[1:] for block in blocks for line in block.splitlines()]
    assert lines
    for verb, *words in lines:
        if verb in ('view', 'fault') or (verb == 'expe' and '--output' not in words):
            continue  # until Ctrl-C, or for a running experiment
        if verb == 'expe':
            words += PATIENT_LAB
        if verb == 'offline':
            words.append('--no-plots')  # which test_offline.py draws
        if verb == 'run':
            words += ['--rtf', '2', '--view', 'none', '--duration', '5', '--no-plots']
        done = run_here(verb, *words, cwd=session)
        assert done.returncode == 0, (verb, words, done.stderr)
