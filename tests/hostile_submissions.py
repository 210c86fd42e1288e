"""Bodies of control laws that attack the grader, and how it must report them."""

RUNS_ON = {
    'recursion': ('    return control(i, n, poses, t)', 'RecursionError'),
    'exit': ('    exit()', 'called exit(None)'),
    'fork': ('    import os\n    while True: os.fork()', 'Operation not permitted'),
    'command': ('    import subprocess\n    subprocess.run(["ls"])', 'Operation not permitted'),
    'rubric': ('    open(RUBRIC)', "Permission denied: '{folder}/rubric.yaml'"),
    'folders': ('    import os\n    os.listdir("/tmp")', 'Permission denied'),
    'environment': (
        '    import os\n    open(f"/proc/{os.getppid()}/environ")',
        '{environ}',
    ),
    'solution': (
        '    from importlib.util import find_spec\n'
        '    file = find_spec("setcmas_ctrl.network").origin\n'
        '    open(file.replace("network", "algorithms/consensus"))',
        'Permission denied',
    ),
    'law': (
        '    from setcmas_ctrl.algorithms.consensus import control',
        'Permission denied',
    ),
    'tmp': ('    open("/tmp/forged", "w")', "{tmp}: '/tmp/forged'"),
    'thread': (
        '    import threading\n    threading.Thread(target=int).start()',
        "can't start new thread",
    ),
    'link': ('    import os\n    os.symlink(RUBRIC, "link")', 'not'),
    'socket': ('    import socket\n    socket.socket()', 'Operation not permitted'),
    'kill': ('    import os\n    os.kill(os.getppid(), 9)', 'Operation not permitted'),
    'ctypes': (
        '    import ctypes, os\n    libc = ctypes.CDLL(None)\n'
        '    calls = libc.fork(), libc.kill(os.getppid(), 9), libc.socket(2, 1, 0)\n'
        '    calls += libc.prctl(1, 0), libc.ptrace(16, os.getppid(), 0, 0), libc.unshare(0)\n'
        '    raise OSError(calls)',
        '(-1, -1, -1, -1, -1, -1)',
    ),
    'limits': (
        '    import resource\n    resource.setrlimit(resource.RLIMIT_CPU, (99, 99))',
        'not implemented',
    ),
    'immutable': (
        '    import fcntl\n    fcntl.ioctl(open("x", "w"), 0x40086602, b"\\x10\\0\\0\\0")',
        'not implemented',
    ),
    'owner': (
        '    import fcntl, os\n    fcntl.fcntl(open("x", "w"), fcntl.F_SETOWN, os.getppid())',
        'not implemented',
    ),
    'truncate': (
        '    import numpy, os\n    os.truncate(numpy.__file__, 0)',
        'Operation not permitted',
    ),
    'open': (
        '    import numpy, os\n    os.open(numpy.__file__, os.O_RDONLY | os.O_TRUNC)',
        'not implemented',
    ),
    'json': ('    print(\'{"score": 10}\')\n    return 1, 1, 1', 'control returned 3 values'),
    'result': ('    return float("inf"), 0', 'not finite'),
}
"""What submissions do, and how it is reported; the run continues without them."""

ENDS = {
    'exit': ('    import os\n    os._exit(0)', 'ended its process with exit status 0'),
    'loading': ('    pass\nimport os\nos._exit(3)', 'ended its process with exit status 3'),
    'signal': ('    import os\n    os.kill(os.getpid(), 9)', 'killed by SIGKILL'),
    'stop': (
        '    import os\n    os.kill(os.getpid(), 19)\n    return 0, 0',
        'the script stopped its process',
    ),
    'crash': ('    import ctypes\n    ctypes.string_at(0)', 'killed by SIGSEGV'),
    'connection': ('    import os\n    os.write(3, bytes(range(99)))', 'on its connection'),
    'answers': (
        '    import os, struct\n'
        '    for _ in range(3): os.write(3, struct.pack("<Q4s", 4, b"full"))\n'
        '    os.close(3)',
        'sent an invalid reply',
    ),
    'messages': (
        '    import os, struct\n'
        '    sent = b\'{"dimensions": [["a", -9, 9999999999999999999999]], "numbers": []}\'\n'
        '    used = b\'"messages": {"are_used": true, "sent": \' + sent + b"}"\n'
        '    reply = b\'{"velocity":[0.0,0.0], \' + used + b"}"\n'
        '    os.write(3, struct.pack("<Q", len(reply)) + reply)\n'
        '    os.close(3)',
        'sent an invalid reply',
    ),
    'place': (
        '    import _signal\n    open("where", "w").write(\n'
        '        f\'(most recent call first):\\n  File "law.py", line {"9" * 5000} in x\\n\')\n'
        '    _signal.raise_signal(9)',
        'killed by SIGKILL',
    ),
    'line': (
        '    import os, struct\n'
        '    reply = b\'{"message": "x", "line": \' + b"9" * 4000 + b"}"\n'
        '    os.write(3, struct.pack("<Q", len(reply)) + reply)\n'
        '    os.close(3)',
        'sent an invalid reply',
    ),
}
"""The same of what ends the run."""

WRITES = {
    'unlinked': (
        '    import os, time\n    files = [open(str(k), "wb") for k in range(8)]\n'
        '    for k in range(8):\n        files[k].write(bytes(2**24))\n        os.unlink(str(k))\n'
        '    time.sleep(9)',
        'No space left on device',
    ),
    'steadily': (
        '    import time\n    open(f"{i} {t}", "wb").write(bytes(2**24))\n    time.sleep(0.1)\n'
        '    return 0, 0',
        'No space left on device',
    ),
    'files': (
        '    import time\n    for k in range(2000): open(str(k), "w").close()\n    time.sleep(9)',
        'No space left on device',
    ),
}
"""What submissions write too much, and the error that they get."""

SLOW = {
    'loop': ('    while True: pass', 'control has not returned for 1 s'),
    'loading': ('    pass\nwhile True: pass', 'has been loading for 1 s'),
    'stubborn': (
        '    import signal\n    signal.signal(signal.SIGUSR1, signal.SIG_IGN)\n'
        '    while True:\n        try:\n            while True: pass\n'
        '        except BaseException: pass',
        'control has not returned for 1 s',
    ),
    'slow': (
        '    import time\n    time.sleep(0.9)\n    return 0, 0',
        'the run takes longer than 4 s',
    ),
    'memory': ('    rest = []\n    while True: rest.append(bytearray(10**7))', 'MemoryError'),
    'large file': ('    open("x", "wb").write(bytes(2**25))', 'File too large'),
    'message': ('    raise OSError("x" * 10**5)', 'OSError'),
}
