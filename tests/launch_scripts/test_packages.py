"""The five ROS packages: same version everywhere, executables that exist, a colcon build."""

import os
import re
import shutil
import signal
import subprocess
import sys
from configparser import ConfigParser
from importlib.metadata import distribution
from pathlib import Path
from xml.etree import ElementTree

import pytest

from setcmas_simu import __version__

ROOT = Path(__file__).parents[2]
HELP = 'setcmas --help'
PLUGINS = (
    'python3 -c "from importlib.metadata import distribution;'
    "print(distribution('setcmas_ctrl').entry_points.groups)\""
)
PACKAGES = ('setcmas_simu', 'setcmas_ctrl', 'setcmas_expe', 'setcmas_tools', 'launch_scripts')


@pytest.mark.parametrize('package', PACKAGES)
def test_manifest(package):
    manifest = ElementTree.parse(ROOT / package / 'package.xml').getroot()

    assert manifest.findtext('name') == package
    assert manifest.findtext('version') == __version__
    assert manifest.findtext('license') == 'MIT'
    assert manifest.findtext('export/build_type') == 'ament_python'
    assert (ROOT / package / 'resource' / package).is_file()


@pytest.mark.parametrize('package', PACKAGES)
def test_every_executable_exists(package):
    for target in declared(package)['console_scripts'].values():
        module, _, function = target.partition(':')
        path = ROOT / package / f'{module.replace(".", "/")}.py'
        assert f'def {function}(' in path.read_text(), path


def test_pip_installs_the_plugins_that_the_packages_declare():
    groups = {}
    for package in PACKAGES:
        for group, targets in declared(package).items():
            if group.startswith('setcmas.'):
                groups.setdefault(group, {}).update(targets)
    installed = {}
    for entry in distribution('setcmas').entry_points:
        if entry.group.startswith('setcmas.'):
            installed.setdefault(entry.group, {})[entry.name] = entry.value

    assert installed == groups, 'pip install --no-deps -e . installs them anew'
    assert groups


def declared(package):
    """Return the entry points in the setup.cfg of a package by group and name."""
    config = ConfigParser(delimiters='=')
    config.read(ROOT / package / 'setup.cfg')
    return {
        group: dict(re.findall(r'^(\S+) = (\S+)$', lines, re.MULTILINE))
        for group, lines in config['options.entry_points'].items()
    }


def test_nothing_at_the_root_makes_colcon_take_it_for_a_package():
    for name in ('setup.py', 'setup.cfg', 'package.xml', 'CMakeLists.txt'):
        assert not (ROOT / name).exists()


@pytest.mark.nightly
@pytest.mark.parametrize('option', [(), ('--symlink-install',)], ids=['plain', 'symlink'])
def test_colcon_builds_the_five_packages(start, domain, tmp_path, option):
    pytest.importorskip('rclpy')
    pytest.importorskip('colcon_ros', reason='colcon is not installed')
    source = tmp_path / 'src' / 'setcmas'
    skipped = shutil.ignore_patterns('.*', '__pycache__', '*.egg-info', 'build', 'install', 'log')
    for package in PACKAGES:
        shutil.copytree(ROOT / package, source / package, ignore=skipped)
    shutil.copy(ROOT / 'pyproject.toml', source)
    for folder in ('tests', 'docs'):
        shutil.copytree(ROOT / folder, source / folder, ignore=skipped)
    binaries = Path(sys.executable).parent
    # A workspace finds its packages by itself, not through an editable install beside it.
    environment = {**os.environ, 'PATH': f'{binaries}:{os.environ["PATH"]}'}
    built = colcon(['build', *option], tmp_path, environment)
    assert 'Summary: 5 packages finished' in built

    launch_files = sorted(path.relative_to(ROOT) for path in ROOT.glob('*/launch/*.py'))
    assert len(launch_files) == 7
    for path in launch_files:
        package = path.parts[0]
        assert (tmp_path / 'install' / package / 'share' / path).is_file()
    for package, name in (('setcmas_simu', 'simulation_8'), ('setcmas_expe', 'experiment_8')):
        assert (tmp_path / 'install' / package / 'share' / package / f'rviz/{name}.rviz').is_file()
    service = 'install/setcmas_expe/share/setcmas_expe/systemd/cmd_vel_guard@.service'
    assert (tmp_path / service).is_file()

    if not option:
        command = ['test', '--packages-select', 'setcmas_simu', '--return-code-on-test-failure']
        colcon([*command, '--pytest-args', '-k', 'fleet'], tmp_path, environment)
        results = ElementTree.parse(tmp_path / 'build' / 'setcmas_simu' / 'pytest.xml').getroot()
        assert int(next(results.iter('testsuite')).get('tests')) > 100

    sourced = subprocess.run(
        ['bash', '-c', f'source install/setup.bash && command -v setcmas && {HELP} && {PLUGINS}'],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert sourced.stdout.startswith(str(tmp_path / 'install' / 'launch_scripts'))
    assert 'simulate robots' in sourced.stdout
    assert 'setcmas.algorithms' in sourced.stdout

    executable = tmp_path / 'install' / 'setcmas_simu' / 'lib' / 'setcmas_simu' / 'virtual_robot'
    command = f'source install/setup.bash && exec {executable} --nb-robots 2'
    node = start('bash', '-c', command, cwd=tmp_path, env=environment)
    node.wait_for_output('simulating robots 1-2')
    publishes(domain)
    assert node.end(signal.SIGTERM) == 0


def colcon(command, folder, environment):
    """Run colcon to a good end, and return what it writes."""
    done = subprocess.run(
        [sys.executable, '-m', 'colcon', '--log-base', 'log', *command],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def publishes(domain):
    from ros_peer import Peer

    with Peer(domain) as peer:
        odometry = peer.odometry(2)
        peer.wait_for(lambda: odometry)
