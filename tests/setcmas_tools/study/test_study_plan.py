import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.scenario.scenario import Scenario
from setcmas_tools.study.study_files import StudyInfo
from setcmas_tools.study.study_plan import Plan, read_cases


def test_the_product_of_all_for_each_seed():
    cases = [{'K': 1, 'vnom': 10}, {'K': 2, 'vnom': 20}]
    info = StudyInfo({}, cases, {'graph': ['ring', 'path', 'star']}, seeds=2)
    plan = Plan(info, Scenario.of('consensus', seed=5))

    assert len(plan.runs) == 12
    assert plan.names == ['K', 'vnom', 'graph']
    assert [run['seed'] for run in plan.runs] == [5] * 6 + [6] * 6
    assert [run['graph'] for run in plan.runs[:4]] == ['ring', 'path', 'star', 'ring']
    assert {(run['K'], run['vnom']) for run in plan.runs} == {(1, 10), (2, 20)}
    assert [*plan.runs[0]] == ['K', 'vnom', 'graph', 'seed']
    for run in (0, 13):
        with pytest.raises(SetcmasError, match='must be from 1 to 12'):
            plan.scenario(run)


def test_a_file_of_cases(tmp_path):
    path = tmp_path / 'cases.csv'
    path.write_text('\ufeffK, graph\n0.5, ring\n\n1, path\n', encoding='utf-8')

    assert read_cases(path, {'K'}) == {
        2: {'K': 0.5, 'graph': 'ring'},
        4: {'K': 1, 'graph': 'path'},
    }
    for text, told in (('K\n', 'a line of names'), ('K,vnom\n1\n', 'line 2 has 1 cells')):
        path.write_text(text)
        with pytest.raises(SetcmasError, match=told):
            read_cases(path, {'K'})
    with pytest.raises(SetcmasError, match='cannot be read'):
        read_cases(tmp_path, {'K'})
