"""All pages for users: their commands are accepted, Python runs, links lead somewhere."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from launch_scripts.cli import VERBS, build_parser
from setcmas_ctrl.communication.graph import load_graph
from setcmas_tools import simulate
from setcmas_tools.grade.rubric import read_rubric

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *sorted((ROOT / 'docs').rglob('*.md'))]
NOT_RUN = '<!-- a piece of a file: not run by the tests -->'


def code(language):
    """Yield the page and the text of each piece of code in a language."""
    for page in PAGES:
        for text in re.findall(rf'^```{language}\n(.*?)^```', page.read_text(), re.S | re.M):
            yield page, text


def commands():
    """Return the words of all setcmas commands, each once."""
    lines = [
        shlex.split(line, comments=True) for _, text in code('sh') for line in text.splitlines()
    ]
    ours = [words[words[0] == 'setcmas' :] for words in lines if words]
    return {' '.join(words): words for words in ours if words[0] in VERBS}


@pytest.mark.parametrize('words', commands().values(), ids=' '.join)
def test_every_command_is_accepted(words):
    args, unknown = build_parser(words[0]).parse_known_args(words)

    assert args.verb == words[0]
    assert not unknown


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_every_link_and_file_of_ours_that_a_page_names_is_there(page):
    text = page.read_text()
    links = re.findall(r'\]\((?!http)([^)#]+)', text) + re.findall(r' src="(.*?)"', text)
    assert [link for link in links if not (page.parent / link).is_file()] == []

    named = re.findall(r'\b((?:setcmas_\w+|launch_scripts|tests|docs)/[\w/]+\.?\w*)', text)
    for name in set(named):
        package = name.partition('/')[0]
        assert (ROOT / name).exists() or (ROOT / package / name).exists(), name


def scripts(function):
    """Return the scripts of all pages that define a function of this name."""
    begin = re.compile(rf'^def {function}\(', re.M)
    return [text for _, text in code('python') if begin.search(text)]


@pytest.mark.parametrize(
    ('function', 'foreign', 'options'),
    [
        ('control', 'setcmas_tools', {'law': '{path}'}),
        ('ctc', 'setcmas_tools', {'event_triggered': True, 'ctc': '{path}'}),
        ('si_to_uni', 'setcmas_tools', {'si_to_uni': '{path}'}),
        ('step', 'RobotModel', {'model': '1-2:{path}'}),
    ],
)
def test_every_script_runs(tmp_path, function, foreign, options):
    alone = [text for text in scripts(function) if foreign not in text]
    for number, text in enumerate(alone):
        path, said = tmp_path / f'script_{number}.py', []
        path.write_text(text)
        given = {
            name: one.format(path=path) if isinstance(one, str) else one
            for name, one in options.items()
        }
        run = simulate(given.pop('law', 'consensus'), 3, 5, **given, warn=said.append)

        assert said == []
        if function == 'step':
            assert (run.poses[-1] != run.poses[0]).any(axis=0).all()
    assert alone


def programs():
    """Return the Python of each page that is no script: its pieces in their order, as one."""
    found = {}
    for page, text in code('python'):
        is_script = (
            re.search(r'def (control|ctc|si_to_uni)\(', text) and 'setcmas_tools' not in text
        )
        if not is_script and f'{NOT_RUN}\n\n```python\n{text}' not in page.read_text():
            found.setdefault(page, []).append(text)
    return found


PROGRAMS = programs()


@pytest.mark.parametrize('page', PROGRAMS, ids=lambda page: page.name)
def test_the_python_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    exec('\n'.join(PROGRAMS[page]), {'__name__': page.stem})


def test_rubrics_can_be_read(tmp_path):
    found = [text for _, text in code('yaml') if 'scenarios:' in text]
    for text in found:
        (tmp_path / 'rubric.yaml').write_text(text)
        assert read_rubric(tmp_path / 'rubric.yaml').max_score == 5
    assert found


def test_the_graph_file_has_the_two_graphs_that_its_picture_shows(tmp_path):
    (text,) = [text for _, text in code('yaml') if 'segments' in text]
    path = tmp_path / 'switching.yaml'
    path.write_text(text)

    pairs, chain = load_graph(path).segments(4)

    assert np.argwhere(pairs.adjacency).tolist() == [[0, 1], [1, 0], [2, 3], [3, 2]]
    assert np.argwhere(chain.adjacency).tolist() == [[0, 1], [1, 2], [2, 3], [3, 2]]
    assert chain.adjacency[1, 2] == 0.5


def test_the_predictions_on_the_page_of_control_scripts_are_those_of_the_run():
    page = (ROOT / 'docs' / 'control_scripts.md').read_text()
    options = r'--algo (\w+) --nb-robots (\d+) --graph (\w+) --duration (\d+)'
    law, robots, graph, duration = re.search(options, page).groups()
    metrics = simulate(law, int(robots), float(duration), graph=graph).metrics()

    assert '\n'.join(metrics['prediction'].lines) in page
