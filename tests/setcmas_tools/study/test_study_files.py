import json

from setcmas_tools.scenario.scenario import Scenario
from setcmas_tools.study.study import read_table, table_of
from setcmas_tools.study.study_files import (
    ROWS,
    StudyInfo,
    finished_rows,
    stored_rows,
    write_table,
)
from setcmas_tools.study.study_plan import Plan

PLAN = Plan(StudyInfo({}, vary={'graph': ['ring', 'a, b']}, seeds=2), Scenario.of('consensus'))
COMPLETE = {'state': 'complete', 'robots': '', 'message': ''}
MADE = [
    {'run': 1, **COMPLETE, 'disagreement': 0.125, 'apples': 2.0},
    {'run': 2, 'state': 'died', 'robots': '2', 'message': 'tb3_2: "dead", at once'},
    {'run': 3, **COMPLETE, 'settling_time': None, 'disagreement': 1e-9},
    {'run': 4, **COMPLETE, 'disagreement': 3.0},
]
TEXT = """\
run,graph,seed,state,robots,message,disagreement,settling_time,apples
1,ring,0,complete,,,0.125,,2
2,"a, b",0,died,2,"tb3_2: ""dead"", at once",,,
3,ring,1,complete,,,1e-09,,
4,"a, b",1,complete,,,3,,
"""


def test_rows_are_in_the_order_of_runs_whenever_they_came(tmp_path):
    rows = {row['run']: row for row in stored_rows(tmp_path, (MADE[k] for k in (2, 0, 3, 1)))}
    write_table(table_of(PLAN, rows), tmp_path)

    assert finished_rows(tmp_path) == rows
    assert (tmp_path / 'runs.csv').read_text() == TEXT
    table = read_table(tmp_path)
    assert table['disagreement'].dropna().tolist() == [0.125, 1e-9, 3.0]
    assert table['robots'].tolist() == ['', '2', '', '']


def test_a_study_goes_on_behind_a_line_that_is_cut_and_makes_damaged_rows_again(tmp_path):
    lines = [json.dumps(row) for row in MADE]
    (tmp_path / ROWS).write_text('\n'.join([lines[0], '{"run": 3, "sta', lines[1][:-9]]))

    assert [*finished_rows(tmp_path)] == [1]
    assert len([*stored_rows(tmp_path, MADE[1:])]) == 3
    assert finished_rows(tmp_path) == {row['run']: row for row in MADE}
