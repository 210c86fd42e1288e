from dataclasses import replace

import numpy as np
import pytest

from setcmas_tools import simulate
from setcmas_tools.measures.metrics import fleet_lines, theory_lines


def told(*arguments, **options):
    """The lines on a run of consensus."""
    return fleet_lines(simulate(*arguments, **options).metrics().parts)


def recorded(run):
    """A run whose commands arrived one after the other, as over ROS."""
    late = replace(run.commands, t=run.commands.t + 1e-5 * run.commands.robot)
    return replace(run, tables=replace(run.tables, commands=late))


@pytest.mark.parametrize('seen', [lambda run: run, recorded])
def test_the_first_run_of_a_newcomer_reads_as_a_success(seen):
    sentence, *others = fleet_lines(seen(simulate('consensus', 8, 40)).metrics().parts)

    assert sentence == (
        'The robots met: at most 0.04 m apart at the end, 0.25 m from the mean of their starts '
        '(all faced +x and drove while turning, which omnidirectional robots need not). '
        'Rate 0.502 1/s, theory 0.527.'
    )
    assert [line.partition(':')[0] for line in others] == ['disagreement', 'centre at the end']


def test_a_rate_far_from_theory_has_a_reason():
    sentence = told('consensus', 8, 40, set={'K': 2.0})[0]

    assert sentence.endswith('1/s, theory 2.55 (the speed limit was reached until 14.0 s).')


def test_robots_that_need_not_turn_meet_where_theory_says():
    sentence = told('consensus', 8, 40, model='omnidirectional')[0]

    assert '0.00 m from the mean of their starts. Rate' in sentence


@pytest.mark.parametrize(
    ('options', 'reason'),
    [
        ({}, 'the speed limit slowed some more than others'),  # of five, three start at y = 5
        ({'graph': 'star'}, 'm from (1.15, 1.92), where theory has them meet ('),
        ({'poses': np.array([[5, 5, -5], [5, -5, -5], [1, 2, 3]]), 'nb_robots': 3}, '(they drove'),
        ({'poses': np.full((3, 2), np.pi / 2) * [[1], [3], [1]], 'nb_robots': 2}, ' 0.00 m from'),
        ({'duration': 5}, 'The robots did not meet: at most 9.50 m apart at the end.'),
    ],
)
def test_the_sentence_fits_the_run(options, reason):
    assert reason in told('consensus', **{'nb_robots': 5, 'duration': 40} | options)[0]


def test_contacts_count_where_robots_are_kept_apart_or_need_not_meet():
    apart = told('consensus', 3, 10, filter='barrier')
    assert any(line.startswith('least separation') for line in apart)
    lines = told('nav_wp', 2, 1, poses=np.zeros((3, 2)))
    assert any(line.startswith('collisions') for line in lines)


def test_what_theory_says_is_told_only_when_asked():
    parts = simulate('consensus', 3, 5).metrics().parts

    assert not any(line.startswith('theory') for line in fleet_lines(parts))
    assert theory_lines(parts)[0].startswith('theory: convergence rate 0.5 1/s')
    parts = simulate('nav_wp', 1, 1).metrics().parts
    assert theory_lines(parts) == ['theory: nothing is predicted for this law']
