import pytest

from setcmas_ctrl.scripts.function import plain_values
from setcmas_simu.errors import SetcmasError


def test_plain_values_are_read_without_running_the_script(tmp_path):
    path = tmp_path / 'law.py'
    path.write_text('raise RuntimeError\nWPL = [[1, 2]]\nN = len(WPL)\nD: float = 2\n')

    assert plain_values(path) == {'WPL': [[1, 2]], 'D': 2}


@pytest.mark.parametrize('value', ['{[1]: 2}', '{{}}'])
def test_values_that_python_cannot_make_are_left_out(tmp_path, value):
    (tmp_path / 'law.py').write_text(f'K = 1\nx = {value}\n')

    assert plain_values(tmp_path / 'law.py') == {'K': 1}


@pytest.mark.parametrize('text', ['WPL = [', f'x = {"-" * 100_000}1'], ids=['open', 'deep'])
def test_a_script_that_is_not_python_is_reported(tmp_path, text):
    (tmp_path / 'law.py').write_text(text)

    with pytest.raises(SetcmasError, match=r'law.py. cannot be read: .'):
        plain_values(tmp_path / 'law.py')
