import pytest

from setcmas_tools.grading.submissions import law_file
from setcmas_tools.grading.submissions.law_file import has_function

LAW = b'def control(i, n, poses, t):\n    return 0, 0\n'


def test_a_law_is_known_by_its_function():
    assert has_function(LAW, 'control')
    assert not has_function(LAW, 'ctc')


def test_what_would_take_minutes_is_not_parsed(monkeypatch):
    monkeypatch.setattr(law_file, '_tree', lambda _: pytest.fail('it is parsed'))

    assert not has_function(LAW + b'f"' + b'{t}' * 80_000 + b'"\n', 'control')
