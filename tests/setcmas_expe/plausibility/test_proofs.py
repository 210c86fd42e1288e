from dataclasses import replace

import pytest

from setcmas_expe.lab.file import DEFAULT_FILE, load_lab
from setcmas_expe.plausibility import proofs
from setcmas_expe.plausibility.proofs import Proofs

LAB = load_lab(DEFAULT_FILE, 2)


@pytest.fixture
def file(tmp_path):
    return tmp_path / 'setcmas' / 'proved.yaml'


def test_proofs_last_for_the_same_bodies_only(file):
    assert Proofs(LAB, file).proved() == []
    Proofs(LAB, file).add([1, 2])

    assert Proofs(LAB, file).proved() == [1, 2]
    turned = replace(LAB, mocap=replace(LAB.mocap, y_up=True))
    assert Proofs(turned, file).proved() == []
    renamed = replace(LAB.robots[0], mocap_name='other')
    assert Proofs(replace(LAB, robots=(renamed, LAB.robots[1])), file).proved() == [2]
    Proofs(LAB, file).drop(1)
    assert Proofs(LAB, file).proved() == [2]


def test_old_proofs_and_broken_files_prove_nothing(file, monkeypatch):
    Proofs(LAB, file).add([1])
    monkeypatch.setattr(proofs, 'LASTING_S', 0.0)
    assert Proofs(LAB, file).proved() == []
    for text in ('[1, 2]', 'robot: [', 'robot 1: x'):
        file.write_text(text)
        assert Proofs(LAB, file).proved() == []
