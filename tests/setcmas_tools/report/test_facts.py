from setcmas_tools.report.facts import facts_of
from setcmas_tools.run.origin import this_origin
from setcmas_tools.run.run import Run
from setcmas_tools.run.run_info import Outcome, RunInfo, State


def test_a_failed_run_says_so_with_command_and_versions(failed_run):
    info = RunInfo(
        ['setcmas', 'run', '--algo', 'my law.py'],
        failed_run.outcome,
        {'nb_robots': 3, 'range': None, 'set': {'K': 1}},
        seed=7,
        started='2026-11-21T16:02:11+0000',
        origin=this_origin(),
    )
    facts = facts_of(Run(failed_run.tables, info))

    assert facts.line == '4 s, begun 2026-11-21 16:02:11'
    assert not facts.well
    assert facts.outcome == 'complete, but law.py failed for robots 1,3'
    assert facts.command == "setcmas run --algo 'my law.py'"
    assert facts.parameters == {'nb_robots': 3, 'set.K': 1}
    assert facts.origin['seed'] == 7
    assert facts.origin['numpy']


def test_a_run_that_died_tells_of_what(failed_run):
    outcome = Outcome(State.DIED, detail='tb3_1: killed\n    9 | x')
    facts = facts_of(Run(failed_run.tables, RunInfo(outcome=outcome)))

    assert (facts.outcome, facts.detail) == ('died: tb3_1: killed', 'tb3_1: killed\n    9 | x')


def test_an_outcome_that_tells_all_is_told_once(failed_run):
    outcome = Outcome(State.DIED, detail='tb3_1: killed')
    facts = facts_of(Run(failed_run.tables, RunInfo(outcome=outcome)))

    assert (facts.outcome, facts.detail) == ('died: tb3_1: killed', '')
