import re
from pathlib import Path

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.page.site_catalogue import catalogue
from setcmas_tools.run.scenario import Scenario


@pytest.fixture(scope='module')
def offered():
    return catalogue()


def by_name(entries):
    return {one['name']: one for one in entries}


def test_laws_and_exercises_have_their_texts(offered):
    laws, exercises = by_name(offered['laws']), by_name(offered['exercises'])

    assert laws['consensus']['text'].startswith('"""')
    assert laws['kuramoto']['settings'] == ['K', 'W', 'DW', 'SPEED', 'WAIT']  # no state
    assert 'TODO' in exercises['consensus']['text']
    texts = [offered['template']['text'], *(one['text'] for one in (laws | exercises).values())]
    assert not [text for text in texts if re.search(r'setcmas (?!_)[a-z]|--[a-z]', text)]
    assert exercises['ctc']['function'] == 'ctc'
    assert exercises['consensus']['points'] == 10
    assert 'def control' in offered['template']['text']


def test_each_law_is_there_once(offered):
    texts = [one['text'] for one in offered['laws']]

    assert len(texts) == len(set(texts))


def test_defaults_of_options_are_those_of_scenarios(offered):
    options = by_name(offered['options'])
    plain = Scenario.of('consensus').values()

    assert {name: one['default'] for name, one in options.items() if name != 'pose'} == {
        name: plain[name] for name in options if name != 'pose'
    }
    assert options['loss'] | {'help': ''} == {
        'name': 'loss', 'help': '', 'input': 'number', 'must_be': 'from 0 to 1', 'default': 0.0,
        'default_text': '', 'unit': '', 'choices': [],
    }  # fmt: skip
    assert 'ring' in options['graph']['choices']
    assert options['event_triggered']['input'] == 'switch'


def test_scenarios_have_their_values_and_scripts(tmp_path):
    law = 'def control(robotNo, nbRobots, poses, t):\n    return 0, 0\n'
    (tmp_path / 'law.py').write_text(law)
    (tmp_path / 'own.yaml').write_text('algo: law.py\nnb_robots: 4\nloss: 0.5\n')
    (tmp_path / 'shipped.yaml').write_text('algo: consensus\n')
    own, shipped = catalogue(scenarios=[tmp_path / 'own.yaml', tmp_path / 'shipped.yaml'])[
        'scenarios'
    ]

    assert own['values'] == {'nb_robots': 4, 'loss': 0.5}
    assert own['script'] == {'name': 'law.py', 'text': law}
    assert (shipped['algo'], shipped['script']) == ('consensus', None)


def test_a_scenario_with_a_mistake_is_refused(tmp_path):
    (tmp_path / 'bad.yaml').write_text('algo: consensus\nlos: 1\n')

    with pytest.raises(SetcmasError, match='did you mean loss'):
        catalogue(scenarios=[Path(tmp_path / 'bad.yaml')])
