import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.run.run_info import State
from setcmas_tools.study.study_cases import CaseTable
from setcmas_tools.study.study_row import Row
from setcmas_tools.study.study_table import ROWS as ROWS_FILE
from setcmas_tools.study.study_table import StudyTable, read_table

CASES = CaseTable([(('graph',), [('ring',), ('a, b',)])], seeds=2)
ROWS = [
    Row(run=1, state=State.COMPLETE, numbers={'disagreement': 0.125, 'apples': 2.0}),
    Row(run=2, state=State.DIED, robots='2', message='tb3_2: "dead", at once'),
    Row(run=3, state=State.COMPLETE, numbers={'settling_time': None, 'disagreement': 1e-9}),
    Row(run=4, state=State.COMPLETE, numbers={'disagreement': 3.0}),
]
TEXT = """\
run,graph,seed,state,robots,message,disagreement,settling_time,apples
1,ring,0,complete,,,0.125,,2
2,"a, b",0,died,2,"tb3_2: ""dead"", at once",,,
3,ring,1,complete,,,1e-09,,
4,"a, b",1,complete,,,3,,
"""


def write(folder, order):
    with StudyTable(folder) as table:
        for index in order:
            table.add(ROWS[index])
        table.finish(CASES)


def test_rows_are_in_the_order_of_runs_whenever_they_came(tmp_path):
    write(tmp_path, (2, 0, 3, 1))

    assert (tmp_path / 'runs.csv').read_text() == TEXT
    table = read_table(tmp_path / 'runs.csv')
    assert table['disagreement'] == [0.125, None, 1e-9, 3.0]
    assert table['graph'] == ['ring', 'a, b'] * 2
    assert table['robots'] == ['', '2', '', '']


def test_a_table_goes_on_behind_the_last_whole_row(tmp_path):
    with StudyTable(tmp_path) as table:
        table.add(ROWS[2])
        table.add(ROWS[0])
    part = tmp_path / ROWS_FILE
    part.write_bytes(part.read_bytes()[:-9])
    with StudyTable(tmp_path) as table:
        assert table.done == {3}
        with pytest.raises(SetcmasError, match='another process'):
            StudyTable(tmp_path)
        for row in (ROWS[0], ROWS[1], ROWS[3]):
            table.add(row)
        table.finish(CASES)

    assert (tmp_path / 'runs.csv').read_text() == TEXT


def test_a_damaged_row_is_reported_with_what_to_do(tmp_path):
    (tmp_path / ROWS_FILE).write_bytes(b'{"run": 1, "sta\n')

    with pytest.raises(SetcmasError, match=r"runs\.jsonl' is damaged .*; delete the line"):
        StudyTable(tmp_path)
