import sys

import pytest
from processes import SETCMAS

from setcmas_expe.emulation.faults import Fault, FaultKind, parse_fault
from setcmas_simu.errors import SetcmasError

LAB = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--nb-robots', '2']


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


def test_faults_are_injected_and_those_of_no_robot_are_reported(start, peer):
    String = pytest.importorskip('std_msgs.msg').String
    lab = start(*LAB)
    lab.wait_for_output('emulating')
    order = peer.publisher(String, '/emulated_lab/fault')

    fault = start(*SETCMAS, 'fault', 'dropout', '--robot', '2', '--for', '1.5')
    assert fault.wait() == 0
    lab.wait_for_output('robot 2, for 1.5 s: motion capture sends nothing')

    order.publish(String(data='nan 3'))
    lab.wait_for_output('the lab has robots 1 to 2')


def test_without_an_emulated_lab_a_fault_says_so(start):
    fault = start(*SETCMAS, 'fault', 'nan')

    assert fault.wait() == 2
    assert 'there is no emulated lab' in fault.output()
