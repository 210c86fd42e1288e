import socket
import sys

import pytest

from setcmas_expe.doctor.discovery_server import server_command
from setcmas_simu.errors import SetcmasError


def test_the_server_of_the_wheels_is_found_and_runs(start):
    pytest.importorskip('rclpy')
    with socket.socket(type=socket.SOCK_DGRAM) as free:
        free.bind(('127.0.0.1', 0))
        port = str(free.getsockname()[1])
    process = start(
        *(sys.executable, '-m', 'setcmas_expe.doctor.discovery_server'),
        *('--address', '127.0.0.1', '--port', port),
    )
    process.wait_for_output(f'[127.0.0.1]:{port}')
    process.end()


def test_without_fast_dds_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, 'executable', str(tmp_path / 'python'))
    monkeypatch.setenv('PATH', str(tmp_path))
    with pytest.raises(SetcmasError, match='ros-jazzy-rclpy'):
        server_command('127.0.0.1', 11811)
