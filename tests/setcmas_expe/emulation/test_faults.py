import sys

import pytest
from processes import SETCMAS

from setcmas_expe.emulation.faults import Fault, FaultKind, parse_fault
from setcmas_simu.errors import SetcmasError

LAB = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--nb-robots', '2']


@pytest.mark.parametrize('kind', FaultKind)
def test_every_fault_is_understood_as_it_is_written(kind):
    assert parse_fault(str(Fault(kind, 2, 1.5))) == Fault(kind, 2, 1.5)


@pytest.mark.parametrize('text', ['', 'dropout 1', 'dropuot 1 3', 'nan one 3', 'nan 1 soon'])
def test_other_texts_are_mistakes(text):
    with pytest.raises(SetcmasError, match=r'it must be .* with one of dropout, nan'):
        parse_fault(text)


def test_faults_are_injected_and_those_of_no_robot_are_reported(start, peer):
    String = pytest.importorskip('std_msgs.msg').String
    lab = start(*LAB)
    lab.wait_for_output('emulating')
    order = peer.publisher(String, '/emulated_lab/fault')

    fault = start(*SETCMAS, 'fault', 'dropout', '--robot', '2', '--for', '1.5')
    assert fault.wait() == 0
    lab.wait_for_output('robot 2, for 1.5 s: motion capture sends nothing')

    for robot in (0, 3):
        order.publish(String(data=f'nan {robot} 1'))
        lab.wait_for_output(f'is for robot {robot}; the lab has robots 1 to 2')


def test_without_an_emulated_lab_a_fault_says_so(start):
    fault = start(*SETCMAS, 'fault', 'nan')

    assert fault.wait() == 2
    assert 'there is no emulated lab' in fault.output()
