"""What is said where bubblewrap is missing, or may not make namespaces."""

import pytest

from setcmas_tools.submissions import confinement
from setcmas_tools.submissions.confinement import obstacle

pytestmark = pytest.mark.skipif(confinement.sys.platform != 'linux', reason='Linux only')


@pytest.fixture
def path(tmp_path, monkeypatch):
    """A folder that is the whole search path for commands."""
    monkeypatch.setenv('PATH', str(tmp_path))
    confinement.confining_command.cache_clear()
    yield tmp_path
    confinement.confining_command.cache_clear()


def write_command(path, name, script):
    (path / name).write_text(f'#!/bin/sh\n{script}\n')
    (path / name).chmod(0o755)


@pytest.mark.parametrize(
    ('manager', 'command'),
    [
        ('apt-get', 'sudo apt-get install bubblewrap'),
        ('dnf', 'sudo dnf install bubblewrap'),
        ('none', 'install bubblewrap'),
    ],
)
def test_where_bubblewrap_is_missing_the_command_that_installs_it_is_named(path, manager, command):
    write_command(path, manager, '')

    assert obstacle() == f'bubblewrap is missing; to install it: {command}, or use Docker'


@pytest.mark.parametrize(
    ('restricted', 'error', 'remedy'),
    [
        ('1', 'setting up uid map: Permission denied', 'sudo apparmor_parser -r /etc/apparmor.d'),
        ('0', 'No permissions to create new namespace', 'in Docker, add --security-opt seccomp'),
        ('1', 'Unknown option --disable-userns', 'bubblewrap 0.8 or later is needed'),
    ],
)
def test_where_it_may_make_no_namespaces_the_remedy_is_named(
    path, monkeypatch, restricted, error, remedy
):
    (path / 'restricted').write_text(f'{restricted}\n')
    monkeypatch.setattr(confinement, '_RESTRICTED', path / 'restricted')
    write_command(path, 'bwrap', f'echo "bwrap: {error}" >&2; exit 1')

    reason = obstacle()

    assert reason.startswith(f'{error}; ')
    assert remedy in reason
    assert '\n' not in reason


@pytest.mark.parametrize('system', ['darwin', 'win32'])
def test_elsewhere_docker_or_wsl_is_named(monkeypatch, system):
    monkeypatch.setattr(confinement.sys, 'platform', system)

    assert obstacle() == 'bubblewrap runs on Linux only; use Docker or, on Windows, WSL 2'
