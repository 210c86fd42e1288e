import random
import subprocess
import sys

import numpy as np
import pytest

from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators

DRAWS = {
    'default_rng': 'np.random.default_rng().random()',
    'RandomState': 'np.random.RandomState().rand()',
    'Generator': 'np.random.Generator(np.random.PCG64()).random()',
    'SeedSequence': 'np.random.SeedSequence(pool_size=8).entropy % 1000',
    'Random': 'random.Random().random()',
    'random': 'random.random()',
    'seed': '[random.seed(), random.random()][1]',
    'numpy': 'np.random.rand()',
    'numpy seed': '[np.random.seed(), np.random.rand()][1]',
}


@pytest.fixture
def draws(tmp_path):
    """Return what a script with some text draws for a robot, with a seed."""
    path = tmp_path / 'law.py'

    def draw(text, robot=1, seed=3):
        lines = 'import random', 'import numpy as np', f'drawn = [{text}, {text}]'
        path.write_text('\n'.join([*lines, 'def control(robotNo, nbRobots, poses, t): ...']))
        with seeded_generators():
            seed_scripts(seed, robot)
            return load_script(path, robot).drawn

    return draw


@pytest.mark.parametrize('text', DRAWS.values(), ids=DRAWS)
def test_what_scripts_draw_follows_from_the_seed_and_the_robot(draws, text):
    first = draws(text)

    assert first[0] != first[1]
    assert draws(text) == first
    assert draws(text, seed=4) != first
    assert draws(text, robot=2) != first


def test_a_generator_of_a_robot_does_not_depend_on_the_robots_of_its_process(draws, tmp_path):
    alone = draws('np.random.default_rng().random()', robot=2)
    with seeded_generators():
        seed_scripts(3, first_robot=1)
        load_script(tmp_path / 'law.py', 1)
        assert load_script(tmp_path / 'law.py', 2).drawn == alone


def test_a_seed_of_a_script_remains(draws):
    assert draws('np.random.default_rng(5).random()')[0] == np.random.default_rng(5).random()
    assert draws('random.Random(5).random()')[0] == random.Random(5).random()


def test_generators_of_others_have_no_seed():
    with seeded_generators():
        seed_scripts(3)
        drawn = {np.random.default_rng().random(), random.Random().random()}
        seed_scripts(3)
        assert not drawn & {np.random.default_rng().random(), random.Random().random()}


def test_everything_is_as_it_was_afterwards():
    def state():
        return random.seed, random.Random.seed, np.random.bit_generator.randbits

    before = state()
    with seeded_generators():
        assert state() != before
    assert state() == before


IMPORTED_BY_THE_SCRIPT = """
import sys
from pathlib import Path
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
with seeded_generators():
    with seeded_generators():
        seed_scripts(3)
        assert 'numpy.random' not in sys.modules
        print(load_script(Path(sys.argv[1]), 1).drawn)
        bit_generator = sys.modules['numpy.random.bit_generator']
        bits = bit_generator.randbits
    assert bit_generator.randbits is bits
assert bit_generator.randbits is not bits
"""


@pytest.mark.parametrize('text', ['np.random.rand()', 'np.random.default_rng().random()'])
def test_numpy_is_seeded_alike_if_a_script_imports_its_generators_first(draws, tmp_path, text):
    drawn = draws(text)
    command = [sys.executable, '-c', IMPORTED_BY_THE_SCRIPT, str(tmp_path / 'law.py')]
    assert subprocess.check_output(command, text=True).strip() == str(drawn)


def test_a_process_whose_scripts_draw_nothing_does_not_import_generators():
    code = """
import sys
before = list(sys.meta_path)
from setcmas_ctrl.laws.script_seeds import seed_scripts, seeded_generators
with seeded_generators():
    seed_scripts(3)
assert sys.meta_path == before
assert not {'numpy.random', '_hashlib'} & sys.modules.keys()
"""
    subprocess.check_call([sys.executable, '-c', code])
