import math

import pytest

from setcmas_simu.errors import SetcmasError
from setcmas_tools.study.success import Success, wilson

ROW = {'disagreement': 0.05, 'least_separation': 0.3, 'settling_time': math.nan}


@pytest.mark.parametrize(
    ('expression', 'successful'),
    [
        ('disagreement<0.1 and least_separation>0.2', True),
        ('0.01 < disagreement < 0.04 or not least_separation > 0.2', False),
        ('settling_time < 30', False),
        ('disagreement * 2 <= 0.1', True),
    ],
)
def test_expressions(expression, successful):
    assert Success(expression, ROW).of(ROW) is successful


@pytest.mark.parametrize(
    ('expression', 'told'),
    [
        ('disagrement < 1', 'did you mean disagreement'),
        ('disagreement <', 'invalid success'),
        ('disagreement / 0', 'division by zero'),
        ("__import__('os').system('true')", 'unknown column'),
        ('disagreement.__class__', 'not available'),
        ('(lambda: 1)()', 'Lambda'),
        ('9**9**9**9', 'evaluate'),
    ],
)
def test_an_invalid_expression_is_reported(expression, told):
    with pytest.raises(SetcmasError, match=told):
        Success(expression, ROW).of(ROW)


def test_wilson_intervals():
    # Newcombe, Statistics in Medicine 17(8), 1998, table I, method 3.
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)
