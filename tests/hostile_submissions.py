"""Control laws that attack the grader, and files that attack whoever unpacks them."""

import io
import zipfile

HEAD = """
import ctypes, errno, mmap, os, resource, signal, socket, stat, subprocess, sys, threading, time
from importlib.util import find_spec
from pathlib import Path

libc = ctypes.CDLL(None, use_errno=True)

def opens(path, secret=b'SECRET'):
    return secret in Path(path).read_bytes()

def writes(path):
    Path(path).write_text('forged')
    return True

def answers(kind, family, place):
    with socket.socket(family, kind) as one:
        one.settimeout(2)
        one.connect(place)
        one.send(b'x')
        return one.recv(10) == b'SECRET'

def shipped(name):
    return os.path.join(os.path.dirname(find_spec('setcmas_ctrl').origin), name)

def fails(number):
    return number != -1

def limit(name, value):
    resource.setrlimit(getattr(resource, 'RLIMIT_' + name), (value, value))
    return True
"""

TRIES = {
    # reads
    'solution': 'opens(PLACE + "/solution.py")',
    'symbolic link': 'os.symlink(PLACE + "/rubric.yaml", "link") or opens("link")',
    'environment of the grader': 'opens(f"/proc/{GRADER}/environ")',
    'memory of the grader': 'open(f"/proc/{GRADER}/maps").read() != ""',
    'processes': 'any(map(str.isdigit, os.listdir("/proc")))',
    'descriptors': 'any(is_other_file(number) for number in range(3, 64))',
    'passwords': 'Path("/etc/shadow").read_bytes() != b""',
    'checkout': 'os.listdir(CHECKOUT) != []',
    'hardware': 'os.listdir("/sys") != []',
    'shipped law': '__import__("setcmas_ctrl.algorithms.consensus") is not None',
    # writes
    'marks': 'writes(PLACE + "/marks.json")',
    'write to the home': 'writes(USER_HOME + "/.setcmas_forged")',
    'write to packages': 'writes(os.path.dirname(find_spec("numpy").origin) + "/forged.py")',
    'write to the system': 'writes("/usr/forged")',
    'shared memory of files': 'writes("/dev/shm/forged")',
    # network
    'TCP': 'answers(socket.SOCK_STREAM, socket.AF_INET, ("127.0.0.1", TCP))',
    'abstract socket': 'answers(socket.SOCK_STREAM, socket.AF_UNIX, ABSTRACT)',
    'the internet': 'socket.create_connection(("1.1.1.1", 53), 1) is not None',
    # other processes
    'signal': 'os.kill(GRADER, 0) is None',
    'trace': 'fails(libc.ptrace(0x4206, GRADER, 0, 0))',
    'fork': 'os.fork() is not None',
    'thread': 'threading.Thread(target=int).start() is None',
    'program': 'subprocess.run([sys.executable, "-c", ""]).returncode == 0',
    'shared memory': 'fails(libc.shmget(KEY, 64, 0))',
    'terminal': 'os.open("/dev/tty", os.O_RDWR) >= 0',
    # rights and limits
    'namespaces': 'libc.unshare(0x10000000) == 0',
    'mount': 'libc.mount(b"none", b"/tmp", b"tmpfs", 0, None) == 0',
    'root': 'os.setuid(0) is None',
    'more memory': 'limit("AS", 1 << 33)',
    'memory': 'len(bytearray(3 << 30)) > 0',
    'large file': 'open("large", "wb").write(bytes(1 << 25)) > (1 << 24)',
    'open files': 'len([open("/dev/null") for _ in range(500)]) == 500',
    'disk': 'fills_disk()',
}  # fmt: skip
"""What a submission tries, by name: an expression that is true where it works."""

WORK_WITHOUT = {
    'solution', 'symbolic link', 'checkout', 'shipped law',
    'marks', 'TCP', 'abstract socket', 'signal', 'shared memory', 'memory of the grader',
    'processes', 'hardware',
}  # fmt: skip
"""Those that work without the sandbox, on any machine, whoever grades."""

LAW = """
def is_other_file(number):
    try:
        kind = os.fstat(number).st_mode
    except OSError:
        return False
    return not (stat.S_ISFIFO(kind) or stat.S_ISCHR(kind))

def fills_disk():
    for number in range(12):
        with open(f"full {number}", "wb") as file:
            file.write(bytes(1 << 23))
    return True

def control(robotNo, nbRobots, poses, t):
    worked = []
    for number, attack in enumerate(TRIES):
        try:
            if eval(attack, globals()):
                worked.append(str(number))
        except (OSError, ImportError, MemoryError, ValueError, RuntimeError, AttributeError):
            pass
    raise ValueError(f'worked: {" ".join(worked)}.')
"""


def trying(tries, **known):
    """Return a law that tries what is in a list, and raises an error with what has worked."""
    values = ''.join(f'{name} = {value!r}\n' for name, value in known.items())
    return f'{HEAD}\n{values}TRIES = {tries!r}\n{LAW}'


_IMPORTS = '    import atexit, ctypes, msgspec, os, signal, struct, sys, time\n    '


def _bodies(table):
    """Return bodies of `control` that import what they need, and how each is reported."""
    return {name: (_IMPORTS + code, report) for name, (code, report) in table.items()}


ENDS = _bodies({
    'exit': ('os._exit(0)', 'ended its process with exit status 0'),
    'signal': ('os.kill(os.getpid(), 9)', 'killed by SIGKILL'),
    'huge length': ('os.write(4, b"\\xff" * 4)', 'wrote on its connection'),
    'not a number': (
        'data = msgspec.msgpack.encode({"numbers": [float("nan"), 0.0]})\n'
        '    os.write(4, struct.pack("<I", len(data)) + data); os.close(4)', 'invalid reply',
    ),
    'nested data': (
        'os.write(4, struct.pack("<I", 8000) + b"\\x91" * 8000); os.close(4)', 'invalid reply'
    ),
    'no message': (
        'data = msgspec.msgpack.encode({"numbers": [0.0, 0.0], "sent": "{}"})\n'
        '    os.write(4, struct.pack("<I", len(data)) + data); os.close(4)', 'invalid reply',
    ),
    'place': (
        'os.write(5, b"  File \\"/submission/law.py\\", line "\n'
        '        + b"9" * 5000 + b" in x\\n"); os._exit(1)',
        'ended its process with exit status 1',
    ),
})  # fmt: skip
"""Bodies of laws that end their run, and how it is reported."""

_HANGS = 'control has not returned for 1 s'
SLOW = _bodies({
    'loop': ('while True: pass', _HANGS),
    'loading': ('pass\nwhile True: pass', 'law.py has been loading for 1 s'),
    'stubborn': (
        'signal.signal(signal.SIGALRM, signal.SIG_IGN)\n    while True:\n        try:\n'
        '            while True: pass\n        except BaseException: pass', _HANGS,
    ),
    'closed': ('os.closerange(0, 99); time.sleep(99)', _HANGS),
    'slow': ('time.sleep(0.9); return 0, 0', 'the run takes longer than 3 s'),
})  # fmt: skip
"""The same of those that take too long, with a limit of 1 s for a call and 3 s for a run.

The last has more time for a call.
"""

GO_ON = _bodies({
    'recursion': ('return control(i, n, poses, t)', 'RecursionError'),
    'output': ('print("x" * 10**7); return 1, 1, 1', 'control returned 3 values'),
    'at exit': ('atexit.register(time.sleep, 99); return 1, 1, 1', 'control returned 3 values'),
})  # fmt: skip
"""The same of those whose run goes on."""


def archive(files, method=zipfile.ZIP_STORED):
    """Return a zip file."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, 'w', method) as file:
        for name, source in files.items():
            file.writestr(name, source)
    return content.getvalue()
