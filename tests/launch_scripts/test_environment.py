import platform
import sys
from dataclasses import replace
from importlib import metadata

import pytest
from processes import refuses, run_setcmas

from launch_scripts import environment
from launch_scripts.experiment import experiment_environment
from setcmas_expe.lab.lab_file import DEFAULT_FILE, load_lab
from setcmas_simu.errors import SetcmasError


def test_topics_stay_on_this_machine_unless_the_user_decides_otherwise(monkeypatch):
    monkeypatch.delenv('ROS_AUTOMATIC_DISCOVERY_RANGE', raising=False)
    assert environment.local_environment()['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'

    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    assert environment.local_environment()['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'SUBNET'


def test_nodes_import_numpy_without_threads_that_spin(monkeypatch):
    monkeypatch.delenv('OPENBLAS_NUM_THREADS', raising=False)
    assert environment.local_environment()['OPENBLAS_NUM_THREADS'] == '1'
    monkeypatch.setenv('OPENBLAS_NUM_THREADS', '2')
    assert environment.local_environment()['OPENBLAS_NUM_THREADS'] == '2'


def test_an_emulated_lab_reaches_no_real_robot_whatever_the_user_has_set(monkeypatch):
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    monkeypatch.setenv('ROS_STATIC_PEERS', '192.168.1.21')
    monkeypatch.setenv('ROS_DISCOVERY_SERVER', '192.168.1.10:11811')
    monkeypatch.setenv('ROS_SUPER_CLIENT', 'TRUE')
    monkeypatch.setenv('FASTRTPS_DEFAULT_PROFILES_FILE', 'out.xml')
    lab = replace(load_lab(DEFAULT_FILE, 1), static_peers=('192.168.1.22',))
    closed = experiment_environment(lab, emulated=True)

    assert closed['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'
    assert not [name for name in closed if name.startswith(('ROS_ST', 'ROS_DIS', 'ROS_SUP'))]
    assert 'FASTRTPS_DEFAULT_PROFILES_FILE' not in closed
    assert experiment_environment(lab, emulated=False)['ROS_STATIC_PEERS'] == '192.168.1.21'


def test_processes_see_the_whole_graph_of_a_discovery_server(monkeypatch):
    assert 'ROS_SUPER_CLIENT' not in environment.local_environment()

    monkeypatch.setenv('ROS_DISCOVERY_SERVER', '192.168.1.10:11811')
    assert environment.local_environment()['ROS_SUPER_CLIENT'] == 'TRUE'


def test_a_static_peer_that_does_not_exist_is_reported_in_one_line(monkeypatch):
    monkeypatch.delenv('ROS_STATIC_PEERS', raising=False)
    lab = replace(load_lab(DEFAULT_FILE, 1), static_peers=('192.168.1.21', 'robot..1'))

    with pytest.raises(SetcmasError, match=r"unknown static peer 'robot\.\.1'"):
        experiment_environment(lab, emulated=False)


def test_an_empty_entry_of_pythonpath_is_left_out(monkeypatch):
    monkeypatch.setenv('PYTHONPATH', ':/somewhere:.')

    assert environment.local_environment()['PYTHONPATH'] == '/somewhere'


@pytest.mark.parametrize('domain', ['abc', '300'])
def test_a_domain_that_is_none_is_refused(monkeypatch, domain):
    monkeypatch.setenv('ROS_DOMAIN_ID', domain)

    with pytest.raises(SetcmasError, match=f"ROS_DOMAIN_ID is '{domain}'; it must be 0 to 232"):
        environment.require_ros()


@pytest.mark.nightly
def test_a_run_is_silent_but_for_its_script_whatever_its_name_and_the_environment(tmp_path):
    name = '共识 é a$b$c_$.py'
    (tmp_path / name).write_text(
        'import sys\n'
        'def control(i, n, p, t):\n    print("mine", file=sys.stderr)\n    return 0.1, 0\n',
        encoding='utf-8',
    )
    left_behind = {'MPLBACKEND': 'module://matplotlib_inline.backend_inline'}
    result = run_setcmas(
        'offline', '--algo', name, '--duration', '1', '-o', 'out', cwd=tmp_path, **left_behind
    )

    assert result.returncode == 0, result.stderr
    assert {line.split(': ', 1)[1] for line in result.stderr.splitlines()} == {'mine'}
    assert (tmp_path / 'out' / 'plots' / 'trajectories.png').is_file()


def test_a_middleware_without_wheels_is_reported(domain, monkeypatch):
    pytest.importorskip('rclpy')
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    monkeypatch.setenv('RMW_IMPLEMENTATION', 'rmw_cyclonedds_cpp')

    refuses('simu', message='unset RMW_IMPLEMENTATION', cwd='.')


def install(folder, trial=''):
    """Lay out the packages of a ROS 2 as apt does, as far as a start of Python sees them."""
    for package in environment._PACKAGES:
        (folder / package).mkdir(parents=True)
        (folder / package / '__init__.py').touch()
    (folder / 'rclpy' / 'serialization.py').write_text(
        f'def serialize_message(message):\n    {trial or "pass"}\n'
    )
    (folder / 'geometry_msgs' / 'msg.py').write_text('class PoseWithCovariance: ...')
    return folder


@pytest.fixture
def path(monkeypatch, tmp_path):
    """Python's search path without a ROS 2; also that of processes that it starts."""
    installed = tmp_path / 'installed'
    installed.mkdir()
    found = metadata.distribution('setcmas')._path
    (installed / found.name).symlink_to(found)
    for name in environment._PACKAGES:
        monkeypatch.delitem(sys.modules, name, raising=False)
    without = [one for one in sys.path if 'site-packages' not in one]
    monkeypatch.setattr(sys, 'path', [*without, str(installed)])

    def put(*folders):
        sys.path[:0] = map(str, folders)
        monkeypatch.setenv('PYTHONPATH', ':'.join(map(str, folders)))

    return put


@pytest.mark.parametrize(
    ('machine', 'message'),
    [
        ('x86_64', r"is missing \(rclpy\): pip install 'setcmas\[ros\]'"),
        ('aarch64', 'not for Linux on aarch64; source the'),  # PyPI has none
    ],
)
def test_without_ros_a_command_says_what_installs_it(path, monkeypatch, machine, message):
    monkeypatch.setattr(platform, 'machine', lambda: machine)

    with pytest.raises(SetcmasError, match=message) as caught:
        environment.check_ros()
    assert ('pip' in str(caught.value)) == (machine == 'x86_64')


def test_two_are_refused_with_both_folders(path, tmp_path):
    sourced, wheels = install(tmp_path / 'opt'), install(tmp_path / 'venv')
    path(sourced, wheels)

    with pytest.raises(SetcmasError, match=f'twice, in {sourced} and {wheels}: use a terminal'):
        environment.check_ros()


def test_one_that_does_not_work_is_refused(path, tmp_path):
    reason = 'numpy.core.multiarray failed to import'
    path(install(tmp_path / 'opt', trial=f'raise ImportError({reason!r})'))

    with pytest.raises(SetcmasError, match=f"not work with Python .* 'numpy<2'; .*: {reason}$"):
        environment.check_ros()


def test_one_that_works_is_taken(path, tmp_path):
    path(install(tmp_path / 'opt'))

    environment.check_ros()
