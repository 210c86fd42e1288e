import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.study.study_cases import CaseTable, read_cases
from setcmas_tools.study.variation import Draw


def test_the_product_of_all_for_each_seed():
    axes = [(('K', 'vnom'), [(1, 10), (2, 20)]), (('graph',), [('ring',), ('path',), ('star',)])]
    table = CaseTable(axes, {'mass': Draw('uniform', 1.0, 2.0)}, seed=5, seeds=2)
    cases = [table.values(run) for run in range(1, len(table) + 1)]

    assert len(cases) == 12
    assert table.names == ['K', 'vnom', 'graph', 'mass']
    assert [case['seed'] for case in cases] == [5] * 6 + [6] * 6
    assert [case['graph'] for case in cases[:4]] == ['ring', 'path', 'star', 'ring']
    assert {(case['K'], case['vnom']) for case in cases} == {(1, 10), (2, 20)}
    assert len({case['mass'] for case in cases}) == 12  # a draw for each run
    assert table.values(3) == cases[2]
    for run in (0, 13):
        with pytest.raises(SetcmasError, match='must be from 1 to 12'):
            table.values(run)


def test_a_file_of_cases(tmp_path):
    path = tmp_path / 'cases.csv'
    path.write_text('\ufeffK, graph\n0.5, ring\n\n1, path\n', encoding='utf-8')

    assert read_cases(path) == (['K', 'graph'], {2: ['0.5', 'ring'], 4: ['1', 'path']})
    for text, told in (('K\n', 'a line of names'), ('K,vnom\n1\n', 'line 2 has 1 cells')):
        path.write_text(text)
        with pytest.raises(SetcmasError, match=told):
            read_cases(path)
    with pytest.raises(SetcmasError, match='cannot be read'):
        read_cases(tmp_path)
