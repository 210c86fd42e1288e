import argparse

import numpy as np
import pytest

from setcmas_ctrl.communication.communication_options import (
    CommunicationOptions,
    check_communication,
    chosen_communication,
)
from setcmas_ctrl.communication.delay_and_loss import Channel
from setcmas_ctrl.laws.script_errors import ErrorReports
from setcmas_simu.errors import SetcmasError


def parsed(*arguments):
    parser = argparse.ArgumentParser(allow_abbrev=False)
    CommunicationOptions.add_to(parser)
    return CommunicationOptions.of(parser.parse_args(arguments))


def chosen(*arguments, nb_robots=4):
    return chosen_communication(nb_robots, parsed(*arguments))


def test_without_options_it_is_that_of_the_ros_1_stack():
    assert chosen().is_ideal


@pytest.mark.parametrize(
    'option',
    ['--event-triggered', '--graph=ring', '--range=3', '--delay=0.2', '--loss=0.1', '--noise=0.1'],
)
def test_each_option_changes_it(option):
    assert not chosen(option).is_ideal
    assert chosen(option).reaches_all == (option == '--event-triggered')


def test_options_reach_the_links():
    settings = chosen('--graph=path', '--range=3', '--delay=0.2', '--loss=0.1', '--noise=0.02')

    assert settings.graph.adjacency(0, np.zeros((2, 4)))[0].tolist() == [0, 1, 0, 0]
    assert settings.graph.adjacency(0, np.array([[0.0, 4, 8, 9], [0] * 4])).sum() == 2
    assert settings.channel == Channel(delay=0.2, loss=0.1, noise=0.02)
    assert chosen('--graph=directed-ring').graph.adjacency(0, np.zeros((2, 4)))[3, 0] == 1


def test_event_triggered_robots_hold_their_own_state_unless_told_otherwise():
    for words, known in ((), 1.0), (['--own-state', 'exact'], 2.0):
        links = chosen('--event-triggered', *words).links([1])
        links.send([0], np.ones((3, 1)), 0.0)
        assert links.known_poses(np.full((3, 1), 2.0), 0.1)[0, 0, 0] == known


def test_a_file_and_a_matrix(tmp_path):
    path = tmp_path / 'graph.yaml'
    path.write_text('edges: [1 <- 2]\n')
    of_file = chosen(f'--graph={path}', nb_robots=2)
    of_matrix = chosen_communication(2, CommunicationOptions(graph=[[0, 1], [0, 0]]))

    assert of_file.graph.adjacency(0, np.zeros((2, 2))).tolist() == [[0, 1], [0, 0]]
    assert of_matrix.graph.adjacency(0, np.zeros((2, 2))).tolist() == [[0, 1], [0, 0]]


def test_a_condition_is_found_as_control_scripts_are(tmp_path, monkeypatch):
    (tmp_path / 'often.py').write_text('def ctc(pos, last_pos, t):\n    return True\n')
    monkeypatch.chdir(tmp_path)
    for name in ('often', 'often.py', str(tmp_path / 'often.py')):
        arguments = parsed('--event-triggered', '--ctc', name)
        check_communication(arguments, None)
        send = chosen_communication(2, arguments).broadcast(1, ErrorReports(print))
        assert [send.is_triggered((0, 0, 0), 0, 0.1 * k) for k in range(3)] == [True] * 3


def test_a_condition_may_be_an_exercise(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments = parsed('--event-triggered', '--ctc', 'ctc').found(exercise=True)
    check_communication(arguments, 2)

    assert chosen_communication(2, arguments).event_triggered
    with pytest.raises(SetcmasError, match="script 'ctc' of --ctc not found"):
        check_communication(parsed('--event-triggered', '--ctc', 'ctc'), 2)


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (
            ['--graph', 'rong'],
            r"unknown graph 'rong'; it must be complete, ring.*did you mean ring\?",
        ),
        (['--event-triggered', '--ctc', 'x.py'], "script 'x.py' of --ctc not found"),
        (['--own-state', 'exact'], '--own-state needs --event-triggered; add it'),
        (
            ['--event-triggered', '--ctc', 'law.py'],
            'law.py has no function ctc; its control is for --algo law.py; it must have ctc',
        ),
    ],
)
def test_mistakes_are_found_before_the_fleet_is_known(tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'law.py').write_text('def control(a, b, c, d):\n    return 0, 0\n')

    with pytest.raises(SetcmasError, match=message):
        check_communication(parsed(*arguments), None)


@pytest.mark.parametrize(
    ('options', 'needed'),
    [
        ({}, True),
        ({'event_triggered': True}, False),
        ({'event_triggered': True, 'range': 3}, True),
    ],
)
def test_places_of_robots_that_send_on_events_are_needed_for_a_range_only(options, needed):
    chosen = chosen_communication(2, CommunicationOptions(**options))

    assert chosen.needs_all_poses == needed
