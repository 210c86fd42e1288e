import pytest

from setcmas_ctrl.scripts.plain_values import plain_values
from setcmas_simu.errors import SetcmasError


def test_plain_values_are_read_without_running_the_script(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('raise RuntimeError\nWPL = [[1, 2]]\nN = len(WPL)\nD: float = 2\n')

    assert plain_values(path) == {'WPL': [[1, 2]], 'D': 2}
    path.write_text('WPL = [')
    with pytest.raises(SetcmasError, match=r'law.py. cannot be read'):
        plain_values(path)
