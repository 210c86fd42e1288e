import socket

import pytest

from setcmas_expe.guard import watchdog

pytestmark = pytest.mark.skipif(not hasattr(socket, 'AF_UNIX'), reason='no systemd')


def test_systemd_is_told_that_the_guard_lives(tmp_path, monkeypatch):
    address = str(tmp_path / 'notify')
    monkeypatch.setenv('NOTIFY_SOCKET', address)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(address)
        watchdog.live()
        assert systemd.recv(100) == b'WATCHDOG=1'
    watchdog.live()  # it has ended: no harm
