from pathlib import Path

import pytest

from setcmas_ctrl.laws.references import (
    References,
    references_of,
    references_of_fleet,
)
from setcmas_ctrl.laws.script_loader import load_script
from setcmas_simu.errors import SetcmasError
from setcmas_tools import simulate

CONTROL = '\ndef control(i, n, p, t):\n    return 0, 0\n'


@pytest.fixture
def references_in(tmp_path):
    """A function that returns the references in a script, for a fleet of 3."""

    def references_in(text, settings=None):
        path = tmp_path / 'law.py'
        path.write_text(text + CONTROL)
        names = vars(load_script(path, 1, settings=settings))
        return references_of(names, path, 3)

    return references_in


def test_a_law_says_its_task_in_a_line(references_in):
    text = "task = 'waypoints'\nimport numpy as np\nWPL = np.array([[1, 2], [3, 4]])"

    assert references_in(text) == References(
        'waypoints', {'WPL': [[1, 2], [3, 4]], 'REACHED': 0.1}
    )
    assert references_in('WPL = [[1, 2]]') is None
    assert references_in("task = 'distances'\nD = 3.0", {'D': 2.0}).values['D'] == 2.0


@pytest.mark.parametrize(
    'text',
    [
        "mine = [[0, 1]]\nreferences = {'WPL': mine, 'REACHED': 1}",
        "references = lambda nbRobots: {'WPL': [[0, nbRobots - 2]], 'REACHED': 1}",
    ],
)
def test_a_law_may_have_other_names(references_in, text):
    found = references_in(f"task = 'waypoints'\n{text}")

    assert found == References('waypoints', {'WPL': [[0, 1]], 'REACHED': 1})
    assert References.decoded(found.encoded()) == found


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ("task = 'dance'", "law.py: unknown task 'dance'; did you mean distances"),
        ("task = 'waypoint'", 'did you mean waypoints'),
        ('task = 3', 'task is 3; it must be the name of a task'),
        ("task = 'waypoints'", "defines no WPL, which task 'waypoints' needs"),
        ("task = 'waypoints'\nWPL = [1, 2]", r'WPL is \[1, 2\]; it must be points'),
        ("task = 'waypoints'\nWPL = [[1, float('nan')]]", 'it must be points'),
        ("task = 'distances'\nD = 'far'", "D is 'far'; it must be a number"),
        ("task = 'tracking'\nR = 2", 'defines no W'),
        ("task = 'tracking'\nreferences = 3", 'they must be a dictionary'),
        ("task = 'tracking'\ndef references(n):\n    return 1 / 0", 'ZeroDivisionError'),
        ("task = 'tracking'\ndef references(n):\n    raise SystemExit", 'SystemExit'),
    ],
)
def test_a_mistake_is_reported_in_a_line_and_the_run_goes_on(
    references_in, tmp_path, text, message
):
    with pytest.raises(SetcmasError, match=message):
        references_in(text)
    said = []
    run = simulate(tmp_path / 'law.py', 3, 1.0, warn=said.append)

    assert run.references is None
    assert len(said) == 1
    assert said[0].endswith('the run continues without a task')


def test_the_first_law_that_declares_a_task_counts():
    laws = [({}, Path('a.py')), ({'task': 'distances', 'D': 2}, Path('b.py'))]

    assert references_of_fleet(laws, 2, print) == References(
        'distances', {'D': 2.0, 'REACHED': 0.1}
    )


@pytest.mark.parametrize(
    'text',
    [
        '', '3', '{}', '[' * 100_000, '{"task": 3, "values": {}}', '{"task": "a"}',
        '{"task": "a", "values": {"D": "far"}}', '{"task": "a", "values": {"D": NaN}}',
        '{"task": "a", "values": {"D": [[[[1]]]]}}', '{"task": "a", "values": []}',
    ],
)  # fmt: skip
def test_messages_of_other_nodes_may_be_invalid(text):
    with pytest.raises(ValueError, match='must be'):
        References.decoded(text)


@pytest.mark.parametrize('nb_robots', [1, 5, 12])
@pytest.mark.parametrize(
    ('algo', 'task', 'part'),
    [
        ('nav_wp', 'waypoints', 'waypoints'),
        ('leader_follower_formation', 'formation', 'formation'),
        ('leader_follower_formation', 'formation', 'waypoints'),
        ('leader_follower_distance_formation', 'distances', 'distances'),
        ('traj_tracking', 'tracking', 'tracking'),
        ('consensus', 'consensus', 'consensus'),
        ('velocity_alignment', 'alignment', 'alignment'),
    ],
)
def test_built_in_laws_declare_their_task(algo, task, part, nb_robots):
    metrics = simulate(algo, nb_robots, 2.0).metrics()

    assert metrics.task == task
    needs_two = part in ('formation', 'distances', 'consensus', 'alignment')
    assert (part not in metrics) == (needs_two and nb_robots == 1)
