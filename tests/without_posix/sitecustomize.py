"""A Python without ROS and what only POSIX has, for whatever has this folder on its path."""

import os
import signal
import sys

MODULES = ('fcntl', 'grp', 'posix_ipc', 'pty', 'pwd', 'resource', 'syslog', 'termios', 'tty')
# Not SIGKILL: subprocess needs it where the platform is not win32.
SIGNALS = ('SIGALRM', 'SIGCHLD', 'SIGHUP', 'SIGTSTP', 'SIGUSR1', 'SIGUSR2', 'SIGXFSZ')
OF_SIGNAL = ('alarm', 'pthread_kill', 'pthread_sigmask', 'setitimer', 'siginterrupt')
# Not os.getuid, which pytest needs there, nor os.waitpid, for subprocess, nor os.uname, for numpy.
OF_OS = ('O_NOFOLLOW', 'fork', 'forkpty', 'getpgid', 'killpg', 'memfd_create', 'mkfifo')
OF_OS += ('setpgid', 'setsid')


class Blocker:
    """Finds none of the modules."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        del path, target
        if name in MODULES:
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)


sys.meta_path.insert(0, Blocker)
sys.modules['rclpy'] = None
for name in MODULES:
    sys.modules.pop(name, None)
for name in SIGNALS:
    delattr(signal, name)
    signal.Signals._member_map_.pop(name)
for module, names in ((signal, OF_SIGNAL), (os, OF_OS)):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
