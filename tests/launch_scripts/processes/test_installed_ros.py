"""A command finds no ROS 2, two, or one for another Python or numpy, and says so in one line."""

import platform
import sys
from importlib import metadata

import pytest

from launch_scripts.processes import installed_ros
from setcmas_simu.errors import SetcmasError

THIS = sys.implementation.cache_tag


def install(folder, python=THIS, message='class PoseWithCovariance: ...', trial=''):
    """Lay out the packages of a ROS 2 as apt does, as far as a start of Python sees them."""
    for package in installed_ros._PACKAGES:
        (folder / package).mkdir(parents=True)
        (folder / package / '__init__.py').touch()
    (folder / 'rclpy' / f'_rclpy_pybind11.{python}-x86_64-linux-gnu.so').touch()
    (folder / 'rclpy' / 'serialization.py').write_text(
        f'def serialize_message(message):\n    {trial or "pass"}\n'
    )
    (folder / 'geometry_msgs' / 'msg.py').write_text(message)
    return folder


@pytest.fixture
def path(monkeypatch, tmp_path):
    """Python's search path without a ROS 2; also that of processes that it starts."""
    installed = tmp_path / 'installed'
    installed.mkdir()
    for name in ('numpy', 'setcmas'):
        found = metadata.distribution(name)._path
        (installed / found.name).symlink_to(found)
    without = [one for one in sys.path if 'site-packages' not in one]
    monkeypatch.setattr(sys, 'path', [*without, str(installed)])

    def put(*folders):
        sys.path[:0] = map(str, folders)
        monkeypatch.setenv('PYTHONPATH', ':'.join(map(str, folders)))

    return put


def test_without_ros_a_command_says_what_installs_it(path, monkeypatch):
    monkeypatch.setattr(platform, 'machine', lambda: 'x86_64')

    with pytest.raises(SetcmasError, match=r"is missing \(rclpy\): pip install 'setcmas\[ros\]'"):
        installed_ros.check_ros()


def test_where_pypi_has_no_ros_nobody_is_sent_to_pip(path, monkeypatch):
    monkeypatch.setattr(platform, 'machine', lambda: 'aarch64')

    with pytest.raises(SetcmasError, match='not for Linux on aarch64; source the') as caught:
        installed_ros.check_ros()
    assert 'pip' not in str(caught.value)


def test_two_are_refused_with_both_folders(path, tmp_path):
    sourced, wheels = install(tmp_path / 'opt'), install(tmp_path / 'venv')
    path(sourced, wheels)

    with pytest.raises(SetcmasError, match=f'twice, in {sourced} and {wheels}: use a terminal'):
        installed_ros.check_ros()


def test_one_for_another_python_is_refused(path, tmp_path):
    path(install(tmp_path / 'opt', python='cpython-38'))

    with pytest.raises(SetcmasError, match=f'another Python than {platform.python_version()}'):
        installed_ros.check_ros()


@pytest.mark.parametrize(
    ('numpy', 'advice'), [('2.1.0', "pip install 'numpy<2'"), ('1.26.4', 'source the setup.bash')]
)
def test_one_that_does_not_work_is_refused(path, tmp_path, monkeypatch, numpy, advice):
    reason = 'numpy.core.multiarray failed to import'
    path(install(tmp_path / 'opt', trial=f'raise ImportError({reason!r})'))
    monkeypatch.setattr(installed_ros, 'version', lambda _: numpy)

    with pytest.raises(SetcmasError, match=f'with numpy {numpy}: {advice}.*: {reason}$'):
        installed_ros.check_ros()


def test_one_that_works_is_taken(path, tmp_path):
    path(install(tmp_path / 'opt'))

    installed_ros.check_ros()
