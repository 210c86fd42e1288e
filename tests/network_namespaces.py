"""Machines of a network, made of network namespaces: no multicast, and plugs to pull."""

import contextlib
import ctypes
import multiprocessing
import os
import subprocess
import time
from pathlib import Path

_CLONE_NEWNET = 0x40000000
# Namespaces share /dev/shm: only UDP is a network.
UDP_ONLY = {'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4'}


class NoNetworkError(Exception):
    """This machine cannot make network namespaces."""


def in_a_process(function, *arguments):
    """Call a function of a module in a process of its own, and return what it returns.

    Fast DDS looks at the network once in a process: it must not see another machine's later.
    """
    with multiprocessing.get_context('spawn').Pool(1) as pool:
        return pool.apply(function, arguments)


def on_a_network(function, *arguments):
    """The same of a function that makes a network; skip the test where this machine cannot."""
    import pytest  # benchmarks can do without

    try:
        return in_a_process(function, *arguments)
    except NoNetworkError as error:
        pytest.skip(str(error))


def ip(*arguments: str) -> str:
    done = subprocess.run(['ip', *arguments], check=True, capture_output=True, text=True)
    return done.stdout


class Network:
    """Machines at one switch; everything vanishes at the end."""

    def __init__(self, *names: str) -> None:
        self._prefix = f's{os.getpid()}'
        self.addresses = {name: f'10.77.0.{i}' for i, name in enumerate(names, start=1)}
        self._spaces = [self.space(name) for name in (*names, 'switch')]

    def space(self, name: str) -> str:
        return f'{self._prefix}_{name}'

    def __enter__(self):
        try:
            for space in self._spaces:
                ip('netns', 'add', space)
                ip('-n', space, 'link', 'set', 'lo', 'up')
            switch = self.space('switch')
            ip('-n', switch, 'link', 'add', 'bridge0', 'type', 'bridge')
            ip('-n', switch, 'link', 'set', 'bridge0', 'up')
            for name in self.addresses:
                self._plug_in(name, switch)
            for name in self.addresses:
                self._wait_until_up(name)
        except (OSError, subprocess.CalledProcessError) as error:
            self.__exit__()
            raise NoNetworkError(f'network namespaces need root and iproute2: {error}') from error
        return self

    def __exit__(self, *_):
        for space in self._spaces:
            with contextlib.suppress(OSError):
                subprocess.run(['ip', 'netns', 'del', space], check=False, capture_output=True)

    def _plug_in(self, name: str, switch: str) -> None:
        space = self.space(name)
        ip('-n', space, 'link', 'add', 'eth0', 'type', 'veth', 'peer', name, 'netns', switch)
        ip('-n', switch, 'link', 'set', name, 'master', 'bridge0', 'up')
        # As an access point that drops multicast; what a host sends itself would get through.
        ip('-n', switch, 'link', 'set', name, 'type', 'bridge_slave', 'mcast_flood', 'off')
        ip('-n', space, 'addr', 'add', f'{self.addresses[name]}/24', 'dev', 'eth0')
        ip('-n', space, 'link', 'set', 'eth0', 'up')

    def _wait_until_up(self, name: str) -> None:
        """Wait for the kernel, which calls a plugged-in interface up only a little later.

        Fast DDS ignores an interface that is down when it looks, which is once: a process that
        starts too early never receives anything from another machine.
        """
        show = ['-br', '-n', self.space(name), 'link', 'show', 'eth0']
        while ip(*show).split()[1] != 'UP':
            time.sleep(0.01)

    def cut(self, name: str) -> None:
        """Pull a machine's plug."""
        ip('-n', self.space('switch'), 'link', 'set', name, 'down')

    def restore(self, name: str) -> None:
        """Push a machine's plug in again."""
        ip('-n', self.space('switch'), 'link', 'set', name, 'up')

    def command(self, name: str, command) -> list[str]:
        """Return a command that runs on a machine."""
        return ['ip', 'netns', 'exec', self.space(name), *command]

    @contextlib.contextmanager
    def on(self, name: str):
        """Let sockets that this thread, and threads it starts, open be on a machine."""
        with (
            Path('/proc/thread-self/ns/net').open() as home,
            Path(f'/run/netns/{self.space(name)}').open() as there,
        ):
            _set_namespace(there.fileno())
            try:
                yield
            finally:
                _set_namespace(home.fileno())


def _set_namespace(descriptor: int) -> None:
    if ctypes.CDLL(None, use_errno=True).setns(descriptor, _CLONE_NEWNET):
        raise OSError(ctypes.get_errno(), 'setns')
