import pytest
from processes import refuses

from launch_scripts.cli import main
from setcmas_tools import simulate

LAW = """K = 0.5


def control(robotNo, nbRobots, poses, t):
    x, y = K * (poses[:2].mean(axis=1) - poses[:2, robotNo - 1])
    return x, y
"""


@pytest.fixture
def folders(tmp_path, monkeypatch):
    """Two runs that differ in gain and largest speed."""
    monkeypatch.chdir(tmp_path)
    law = tmp_path / 'law.py'
    for name, gain, vnom in (('one', '0.5', 0.5), ('other', '0.8', 0.4)):
        law.write_text(LAW.replace('0.5', gain))
        simulate(law, 3, 8.0, vnom=vnom).save(name)
    return tmp_path


def test_two_gains_are_compared(folders, capsys):
    """In metrics, script and parameters, and in two pictures."""
    assert main(['compare', 'one', 'other']) == 0

    lines = [' '.join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert 'vnom_m_s 0.5 0.4 -0.1' in lines
    assert 'vnom: 0.5 -> 0.4' in lines
    assert lines[lines.index('-K = 0.5') + 1] == '+K = 0.8'
    assert any(line.startswith('other is 0.') for line in lines)
    pictures = {path.name for path in (folders / 'comparison').iterdir()}
    assert pictures == {'paths.png', 'distances.png'}


def test_one_run_alone_is_refused(folders):
    refuses('compare', 'one', message="'one' is only one run; name at least two", cwd=folders)
