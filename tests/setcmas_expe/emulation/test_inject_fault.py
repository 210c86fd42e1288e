import signal

import pytest

pytest.importorskip('rclpy')

from setcmas_expe.emulation import inject_fault


def test_the_kernel_ends_it_if_ros_never_starts(monkeypatch):
    # alarm(0) cancels the alarm, and returns the seconds that were left.
    monkeypatch.setattr(inject_fault, 'node_main', lambda *_: signal.alarm(0))

    assert 0 < inject_fault.main(['swap', '1']) <= 60
