import pytest

from setcmas_expe.emulation.faults import Fault, FaultKind, parse_fault
from setcmas_simu.errors import SetcmasError


@pytest.mark.parametrize('kind', FaultKind)
def test_every_fault_is_understood_as_it_is_written(kind):
    assert parse_fault(str(Fault(kind, 2, 1.5))) == Fault(kind, 2, 1.5)


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('', 'KIND ROBOT'),
        ('dropout', 'KIND ROBOT'),
        ('dropuot 1', 'dropout, zero'),
        ('nan 0', 'KIND ROBOT'),
        ('nan one', 'KIND ROBOT'),
        ('nan 1 2 3', 'KIND ROBOT'),
        ('nan 1 soon', "is 'soon'; it must be a number above 0 s"),
        ('nan 1 -1', 'is -1; it must be above 0 s'),
        ('nan 1 inf', 'above 0 s and finite'),
    ],
)
def test_other_texts_are_mistakes(text, expected):
    with pytest.raises(SetcmasError, match=expected):
        parse_fault(text)
