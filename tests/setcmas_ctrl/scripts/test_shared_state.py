"""What scripts share with setcmas: seeds of generators, modules, recursion limit, tracing.

The attacks of scripts are in bad; see test_bad_scripts.py.
"""

import builtins
import cProfile
import math
import random
import sys

import numpy as np
import pytest

from setcmas_ctrl.scripts.loader import load_script
from setcmas_ctrl.scripts.shared_state import kept_state, seed_scripts
from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate

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
        with kept_state():
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
    with kept_state():
        seed_scripts(3, first_robot=1)
        load_script(tmp_path / 'law.py', 1)
        assert load_script(tmp_path / 'law.py', 2).drawn == alone


def test_a_seed_of_a_script_remains(draws):
    assert draws('np.random.default_rng(5).random()')[0] == np.random.default_rng(5).random()
    assert draws('random.Random(5).random()')[0] == random.Random(5).random()


def test_generators_of_others_have_no_seed():
    with kept_state():
        seed_scripts(3)
        drawn = {np.random.default_rng().random(), random.Random().random()}
        seed_scripts(3)
        assert not drawn & {np.random.default_rng().random(), random.Random().random()}


def test_a_function_is_warned_of_generators_without_a_seed():
    rng = np.random.default_rng(1)
    said = []

    def control(robotNo, nbRobots, poses, t):
        return rng.random(), np.random.default_rng().random()

    simulate(control, nb_robots=2, duration=1, warn=said.append)

    assert [text.partition(',')[0] for text in said] == [
        'control draws from rng',
        'a function created an unseeded random generator',
    ]


def test_everything_is_as_it_was_afterwards():
    def state():
        modules = builtins, math, np, np.linalg, np.random, random
        own = sys.settrace, sys.setprofile, sys.setrecursionlimit, random.Random.seed
        return [*map(type, modules), *own, np.random.bit_generator.randbits, sys.gettrace()]

    before = state()
    with kept_state():
        assert state() != before
    assert state() == before


def test_a_run_under_a_profiler_with_more_recursion_as_in_a_notebook(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text(
        'import sys\nimport numpy as np\nnp.bool = bool\nsys.setrecursionlimit(2000)\n'
        'def control(robotNo, nbRobots, poses, t):\n    return 0.1, 0.1\n'
    )
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(3000)
    try:
        run = cProfile.Profile().runcall(simulate, path, nb_robots=2, duration=2)
    finally:
        sys.setrecursionlimit(limit)

    assert run.poses[-1, 0, 0] != run.poses[0, 0, 0]
    assert np.bool is not bool


BREAKS = {
    "vars(numpy)['cos'] = numpy.sin": 'numpy.cos',
    "vars(builtins)['len'] = None; del vars(builtins)['vars']": 'builtins.len, builtins.vars',
    "vars(sys)['modules'].pop('math'); math.__dict__.update(hypot=max)": 'math.hypot',
}


@pytest.mark.parametrize('line', BREAKS)
def test_a_script_that_replaces_a_name_in_a_roundabout_way_ends_the_run(tmp_path, line):
    path = tmp_path / 'law.py'
    law = 'def control(robotNo, nbRobots, poses, t):\n    return 0.1, 0.1\n'
    path.write_text(f'import builtins, math, numpy, sys\n{law}    {line}\n{line}\n')
    modules = dict(sys.modules)

    with pytest.raises(SetcmasError, match=rf'a script has changed {BREAKS[line]}, which'):
        simulate(path, nb_robots=2, duration=2)

    assert np.cos(0.0) == 1.0
    assert math.hypot(3, 4) == 5.0
    assert vars(builtins)['len']('four') == 4
    assert sys.modules == {**modules, **sys.modules}


def test_an_error_of_a_script_in_a_function_of_setcmas_is_the_scripts(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('def hook(*_):\n    raise KeyError("mine")\n')
    module = load_script(path, 1, 'hook(_)')

    with (
        pytest.raises(SetcmasError, match=r"law.py, line 2: KeyError: 'mine'"),
        kept_state(),
    ):
        sorted([1, 2], key=module.hook)
