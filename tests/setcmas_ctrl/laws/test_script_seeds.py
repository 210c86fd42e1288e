import random

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
