"""Robots of a run in the sandbox, which try to reach each other past their links."""

import numpy as np
import pytest

from setcmas_tools.grade.rubric_scenarios import MarkedScenario
from setcmas_tools.grade.sandbox import SandboxRunner, Times, sandbox
from setcmas_tools.offline.confinement import obstacle
from setcmas_tools.scenario.scenario import Scenario

pytestmark = pytest.mark.skipif(bool(obstacle()), reason=obstacle())

PAIR = Scenario.of('', nb_robots=2, duration=1.0)
RING = Scenario.of('', nb_robots=4, duration=8.0, graph='ring', loss=0.5)
LAW = """
import ctypes, fcntl, gc, os, signal, socket, sys, tempfile, time
import numpy as np
from multiprocessing import shared_memory

SECRET = 'x = 4.' + '71'
libc = ctypes.CDLL(None, use_errno=True)

def others():
    '''The processes near this one: its siblings, and the one that has forked them.'''
    near = range(os.getpid() - 40, os.getpid() + 40)
    found = [pid for pid in near if pid != os.getpid() and os.path.exists(f'/proc/{pid}')]
    assert os.getppid() in {*found, os.getppid()} and found
    return {*found, os.getppid()}

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
    except OSError:
        return False
    return True

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
        'for fd in range(4, 300):\n'
        '        if works(lambda: os.fstat(fd)) and not os.path.samestat(\n'
        '                os.fstat(fd), os.stat("where")):\n'
        '            return True\n'
        '    return False',
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
}
"""How a robot puts what it knows somewhere, and how another one gets it from there."""


@pytest.fixture(scope='module')
def host(tmp_path_factory):
    with sandbox(tmp_path_factory.mktemp('sandbox'), confined=True) as one:
        yield one


def run(host, source, scenario):
    runner = SandboxRunner(host, 'law.py', {'law.py': source.encode()}, Times(5.0, 20.0))
    return runner(MarkedScenario('one', (), scenario))


@pytest.mark.parametrize('channel', CHANNELS)
def test_robots_of_a_run_have_no_channel_but_their_links(host, channel):
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
