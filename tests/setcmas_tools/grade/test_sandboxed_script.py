"""Robots of a run in the sandbox, which try to reach each other past their links."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from sandboxes import forbid_mounts

from setcmas_tools.grade.rubric_scenarios import MarkedScenario
from setcmas_tools.grade.sandbox import SandboxRunner, Times, sandbox
from setcmas_tools.offline.kernel_confinement import PrivateMounts, obstacle
from setcmas_tools.scenario.scenario import Scenario

pytestmark = pytest.mark.skipif(bool(obstacle()), reason=obstacle())

PAIR = Scenario.of('', nb_robots=2, duration=1.0)
RING = Scenario.of('', nb_robots=4, duration=8.0, graph='ring', loss=0.5)
LAW = """
import ctypes, fcntl, gc, mmap, os, signal, socket, stat, sys, tempfile, threading, time
import numpy as np
from multiprocessing import shared_memory
from pathlib import Path

SECRET = 'x = 4.' + '71'
libc = ctypes.CDLL(None, use_errno=True)

def others():
    '''The processes near this one: its siblings, and the one that has forked them.'''
    near = range(max(2, os.getpid() - 40), os.getpid() + 40)
    return {*near, os.getppid()} - {os.getpid()}

def reads(*paths):
    for path in paths:
        try:
            with open(path, 'rb') as file:
                if SECRET.encode() in file.read(1 << 20):
                    return True
        except OSError:
            pass
    return False

def works(call):
    try:
        call()
    except (OSError, RuntimeError):
        return False
    return True

def number_of_new_file():
    with open('new', 'w') as file:
        number = os.fstat(file.fileno()).st_ino
    return number

def is_sender_of_signal_lost():
    own = signal.SIGRTMIN + 1
    signal.pthread_sigmask(signal.SIG_BLOCK, [own])
    os.kill(os.getpid(), own)
    return signal.sigwaitinfo([own]).si_pid == 0

PACKAGES = sorted(Path(np.__file__).parent.rglob('*.pyi'))
READ_AT = [os.stat(file).st_atime_ns for file in PACKAGES]
FIRST = number_of_new_file()
IS_LOST = is_sender_of_signal_lost()

PUT
def control(i, n, poses, t):
    if i == 1:
        put()
        return 0.0, 0.0
    return (0.25 if get() else 0.0), 0.0
"""
CHANNELS = {
    'modules': (
        'np.told = SECRET',
        'return hasattr(np, "told")',
    ),
    'objects': (
        'global told\n    told = [SECRET]',
        'return any(type(one) is list and one == [SECRET] for one in gc.get_objects())',
    ),
    'environment': (
        'os.environ["TOLD"] = SECRET',
        'return "TOLD" in os.environ or reads(*(f"/proc/{pid}/environ" for pid in others()))',
    ),
    'home': (
        'open("told", "w").write(SECRET)',
        'folders = [f"/proc/{pid}/cwd" for pid in others()] + [".", os.environ["HOME"]]\n'
        '    if works(lambda: os.listdir("..")):\n'
        '        return True\n'
        '    return any(os.path.exists(f"{folder}/told") for folder in folders)',
    ),
    'temporary files': (
        'for folder in ("/tmp", "/dev/shm", "/var/tmp", "..", tempfile.gettempdir()):\n'
        '        works(lambda: open(f"{folder}/told", "w").write(SECRET))',
        'return reads("/tmp/told", "/dev/shm/told", "/var/tmp/told", "../told",\n'
        '        tempfile.gettempdir() + "/told")',
    ),
    'shared memory': (
        'works(lambda: shared_memory.SharedMemory("told", True, 64))\n'
        '    libc.shmget(4711, 64, 0o1666)\n    libc.mq_open(b"/told", 0o102, 0o666, None)',
        'return works(lambda: shared_memory.SharedMemory("told")) or \\\n'
        '        libc.shmget(4711, 64, 0) != -1 or libc.mq_open(b"/told", 0) != -1',
    ),
    'memory of processes': (
        'global told\n    told = SECRET.encode() * 1000',
        'return any(works(lambda: open(f"/proc/{pid}/{name}", "rb"))\n'
        '        for pid in others() for name in ("mem", "maps", "fd/3", "map_files"))',
    ),
    'ptrace': (
        'pass',
        'return any(libc.ptrace(request, pid, 0, 0) != -1\n'
        '        for pid in others() for request in (16, 0x4206))',
    ),
    'process_vm_readv': (
        'pass',
        'here = ctypes.create_string_buffer(8)\n'
        '    span = (ctypes.c_size_t * 2)(ctypes.addressof(here), 8)\n'
        '    read = libc.process_vm_readv\n'
        '    return any(read(pid, span, 1, span, 1, 0) != -1 for pid in others())',
    ),
    'descriptors of others': (
        'pass',
        'opened = [libc.syscall(434, pid, 0) for pid in others()]\n'
        '    return any(one != -1 for one in opened) or any(\n'
        '        works(lambda: os.readlink(f"/proc/{pid}/fd/3")) for pid in others())',
    ),
    'inherited descriptors': (
        'for fd in range(4, 300): works(lambda: os.write(fd, SECRET.encode()))',
        'opened = [fd for fd in range(4, 300) if works(lambda: os.fstat(fd))]\n'
        '    return len(opened) != 1 or SECRET in str(os.fstat(opened[0]).st_size)',
    ),
    'streams': (
        'for fd in range(3): fcntl.fcntl(fd, fcntl.F_SETFL, os.O_NONBLOCK | os.O_APPEND)',
        'return any(fcntl.fcntl(fd, fcntl.F_GETFL) & os.O_NONBLOCK for fd in range(3))',
    ),
    'signals': (
        'global told\n    told = []\n    signal.signal(signal.SIGUSR2, lambda *_: told.append(1))',
        'return any(works(lambda: os.kill(pid, number)) for pid in others()\n'
        '        for number in (0, signal.SIGUSR2))',
    ),
    'sockets': (
        'global told\n'
        '    try:\n'
        '        told = socket.socket(socket.AF_UNIX)\n'
        '        told.bind("\\0told")\n        told.listen()\n'
        '    except OSError:\n        pass',
        'return works(lambda: socket.socket(socket.AF_UNIX).connect("\\0told"))',
    ),
    'flock': (
        'global told\n    told = open(np.__file__)\n'
        '    works(lambda: fcntl.flock(told, fcntl.LOCK_EX))',
        'try:\n'
        '        fcntl.flock(open(np.__file__), fcntl.LOCK_EX | fcntl.LOCK_NB)\n'
        '    except BlockingIOError:\n        return True\n'
        '    except OSError:\n        pass\n'
        '    return False',
    ),
    'record locks': (
        'global told\n    told = open(np.__file__)\n'
        '    works(lambda: fcntl.lockf(told, fcntl.LOCK_SH))\n'
        '    works(lambda: fcntl.fcntl(told, 37, bytes(32)))',
        'return any(works(lambda: fcntl.fcntl(open(np.__file__), get, b"\\1" + bytes(31)))\n'
        '        for get in (fcntl.F_GETLK, 36))',
    ),
    'amount of free space': (
        'open("told", "wb").write(bytes(1 << 23))',
        'return works(lambda: os.statvfs(".")) or libc.sysinfo(bytes(200)) == 0',
    ),
    'threads': (
        'for _ in range(9): works(threading.Thread(target=time.sleep, args=(3,)).start)',
        'tasks = Path(f"/proc/{os.getpid() - 1}/task")\n'
        '    return works(threading.Thread(target=int).start) or (\n'
        '        tasks.exists() and tasks.stat().st_nlink > 9)',
    ),
    'open files': (
        'global told\n    told = [open(np.__file__) for _ in range(20)]',
        'folders = [Path(f"/proc/{pid}/fd") for pid in others()]\n'
        '    return any(os.path.lexists(one / "9") for one in folders) or any(\n'
        '        one.exists() and one.stat().st_size > 20 for one in folders)',
    ),
    'times of files of the system': (
        'works(lambda: os.stat("/proc/sys/kernel/ostype"))',
        'return any(map(os.path.exists, ("/proc/self", "/proc/loadavg", "/sys/kernel")))',
    ),
    'access times': (
        'for file in PACKAGES: file.read_bytes()',
        'return READ_AT != [os.stat(file).st_atime_ns for file in PACKAGES]',
    ),
    'numbers of files': (
        'for k in range(50): open(str(k), "w").close()',
        'global FIRST\n    os.rename("new", "old")\n'
        '    before, FIRST = FIRST, number_of_new_file()\n    return FIRST != before + 1',
    ),
    'numbers of pipes': (
        'for _ in range(20): works(os.pipe)',
        'return works(os.pipe) or works(lambda: os.eventfd(0)) or libc.epoll_create(1) != -1',
    ),
    'processor time': (
        'sum(range(10**6))',
        'return any(libc.clock_gettime(~pid << 3 | kind, bytes(16)) == 0\n'
        '        for pid in others() for kind in (0, 1, 2))',
    ),
    'scheduling': (
        'for call in (os.nice, os.setpgid, os.setpriority):\n'
        '        works(lambda: call(*(5,) * (1 + 2 * (call is os.setpriority))\n'
        '            if call is not os.setpgid else (0, 0)))',
        'calls = (os.sched_getaffinity, os.sched_getscheduler, os.getpgid, os.getsid)\n'
        '    calls += (lambda pid: os.getpriority(os.PRIO_PROCESS, pid),)\n'
        '    return any(works(lambda: call(pid)) for pid in others() for call in calls)',
    ),
    'limits': (
        'pass',
        'return any(libc.prlimit(pid, 7, None, bytes(16)) == 0 for pid in others())',
    ),
    'futex': (
        'pass',
        'with open(np.__file__, "rb") as file:\n'
        '        shared = mmap.mmap(file.fileno(), 4096, mmap.MAP_SHARED, mmap.PROT_READ)\n'
        '    place = np.frombuffer(shared, np.uint8).ctypes.data\n'
        '    return libc.syscall(202, ctypes.c_void_p(place), 1, 1) != -1',
    ),
    'pending signals': (
        'signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGRTMIN])\n'
        '    for _ in range(150_000): libc.kill(os.getpid(), signal.SIGRTMIN)',
        'return is_sender_of_signal_lost() != IS_LOST',
    ),
    'other system calls': (
        'libc.syscall(248, b"user", b"told", b"x", 1, -4)',
        'numbers = [27, 137, 250, 294]  # mincore, statfs, keyctl, inotify_init1\n'
        '    numbers += [327, 319, 323, 434]  # preadv2, memfd_create, userfaultfd, pidfd_open\n'
        '    numbers += [425, 64, 222, 300]  # io_uring_setup, semget, timer_create, fanotify\n'
        '    return any(libc.syscall(number, 0, 0, 0, 0, 0, 0) != -1 for number in numbers)',
    ),
}
"""How a robot puts what it knows somewhere, and how another one gets it from there."""


ONLY_WITH_MOUNTS = (
    'open files', 'times of files of the system', 'access times', 'numbers of files'
)  # fmt: skip
"""Channels that need a view of the file system of one's own, as docs/grading.md says."""


QUICK = [('private mounts', 'open files'), ('no mounts', 'other system calls')]
PLACES = [('private mounts', channel) for channel in CHANNELS]
PLACES += [('no mounts', channel) for channel in CHANNELS if channel not in ONLY_WITH_MOUNTS]
PLACES = [
    pytest.param(*place, marks=() if place in QUICK else pytest.mark.nightly) for place in PLACES
]


@pytest.fixture(scope='module', params=['private mounts'])
def host(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp('sandbox')
    with sandbox(folder, confined=True) as one:
        if request.param == 'no mounts':
            forbid_mounts(one, tmp_path_factory.mktemp('modules'))
        elif not PrivateMounts.are_possible():
            pytest.skip('this system forbids user namespaces')
        yield one


def run(host, source, scenario):
    runner = SandboxRunner(host, 'law.py', {'law.py': source.encode()}, Times(5.0, 20.0))
    return runner(MarkedScenario('one', (), scenario))


@pytest.mark.parametrize(('host', 'channel'), PLACES, indirect=['host'])
def test_robots_of_a_run_have_no_channel_but_their_links(host, channel):
    if channel == 'access times':  # make the first read of each file leave a trace
        for file in Path(np.__file__).parent.rglob('*.pyi'):
            os.utime(file, ns=(0, file.stat().st_mtime_ns))
    put, get = CHANNELS[channel]
    source = LAW.replace('PUT', f'def put():\n    {put}\n\ndef get():\n    {get}\n')

    done = run(host, source, PAIR)

    assert done.failure is None
    assert not done.run.table.of(2).v.any()


HONEST = """
import numpy as np
def control(i, n, poses, t):
    poses = shared(i, np.array(poses))
    others = poses[:2, ~np.isnan(poses[0])]
    return tuple(0.5 * (others - poses[:2, [i - 1]]).mean(axis=1))
def shared(i, poses):
"""
CHEAT = """
    known = vars(np).setdefault('known', {})
    known[i] = poses[:, i - 1]
    for j, pose in known.items():
        poses[:, j - 1] = pose
"""


def test_a_law_gains_nothing_by_what_it_tells_its_other_robots(host):
    honest = run(host, f'{HONEST}    return poses\n', RING).run
    cheat = run(host, f'{HONEST}{CHEAT}    return poses\n', RING).run

    assert np.array_equal(cheat.poses, honest.poses)


def test_modules_for_scripts_are_imported_without_the_extra_of_studies():
    code = (
        'import sys\n'
        "sys.modules['pandas'] = None\n"
        'from setcmas_tools.grade.sandboxed_script import import_for_scripts\n'
        'import_for_scripts()\n'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)

    assert done.returncode == 0, done.stderr
