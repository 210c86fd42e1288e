import signal
from pathlib import Path

import numpy as np
import psutil
import pytest

from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_tools import simulate
from setcmas_tools.grade.rubric_scenarios import CTC, Scenario
from setcmas_tools.grade.sandbox.box import Box
from setcmas_tools.grade.sandbox.confinement import obstacle
from setcmas_tools.grade.sandbox.held import Times
from setcmas_tools.grade.sandbox.runner import BoxRunner

pytestmark = pytest.mark.skipif(bool(obstacle()), reason=obstacle())

FLEET = Scenario('fleet', (), {'nb_robots': 5, 'duration': 8.0})
LOSSY = Scenario('lossy', (), {**FLEET.arguments, 'graph': 'ring', 'loss': 0.2, 'noise': 0.01})
SHORT = Scenario('short', (), {'nb_robots': 2, 'duration': 1.0})
STILL = 'def control(i, n, poses, t):\n    return 0.25, 0\n'
TIMES = Times(1.0, 4.0)
LAWS = ('consensus', 'nav_wp', 'traj_tracking', 'leader_follower_formation')


@pytest.fixture(scope='module')
def box(tmp_path_factory):
    with Box(tmp_path_factory.mktemp('boxes'), confined=True) as one:
        yield one


def run(box, script, scenario=SHORT, times=TIMES, **others):
    files = {'law.py': script} if isinstance(script, bytes) else {'law.py': script.encode()}
    return BoxRunner(box, 'law.py', files, times, **others)(scenario)


def still(i, n, poses, t):
    return 0.25, 0


def same(one, other):
    pairs = zip(vars(one.table).values(), vars(other.table).values(), strict=True)
    return all(np.array_equal(*pair) for pair in pairs)


@pytest.mark.parametrize('law', [*LAWS, 'leader_follower_distance_formation'])
def test_a_law_in_a_box_drives_as_it_does_offline_to_the_last_bit(box, law):
    file = ALGORITHMS.file(law)

    done = run(box, file.read_bytes(), FLEET)

    assert same(done.run, simulate(file, **FLEET.arguments))
    assert done.failure is None


def test_a_law_in_a_box_hears_and_draws_lots_as_it_does_offline(box, tmp_path):
    source = b'import random\nfrom setcmas_ctrl import network\nK = 1\n'
    source += b'def control(i, n, poses, t):\n'
    source += b'    return random.random(), K * len(network.neighbours()) * poses[0, i - 1]\n'
    (tmp_path / 'law.py').write_bytes(source)
    scenario = Scenario('set', (), {**LOSSY.arguments, 'seed': 3, 'settings': {'K': -0.1}})

    own = simulate(tmp_path / 'law.py', **scenario.arguments)

    assert same(run(box, source, scenario).run, own)


@pytest.mark.parametrize('speeds', [False, True])
def test_a_condition_in_a_box_triggers_as_it_does_offline(box, tmp_path, speeds):
    arguments = 'pos, vit, last_pos, last_vit, t' if speeds else 'pos, last_pos, t'
    source = f'def ctc({arguments}):\n    return abs(pos - last_pos).sum() > 0.2\n'
    (tmp_path / 'law.py').write_text(source)
    scenario = Scenario('ctc', (), {'algo': 'consensus', **FLEET.arguments} | TRIGGERED)

    own = simulate(**scenario.arguments, ctc=tmp_path / 'law.py')

    assert same(run(box, source, scenario, function=CTC).run, own)


TRIGGERED = {'event_triggered': True}

RUNS_ON = {
    'recursion': ('    return control(i, n, poses, t)', 'RecursionError'),
    'exit': ('    exit()', 'called exit(None)'),
    'fork': ('    import os\n    while True: os.fork()', 'Operation not permitted'),
    'command': ('    import subprocess\n    subprocess.run(["ls"])', 'Operation not permitted'),
    'rubric': ('    open(RUBRIC)', "Permission denied: '{folder}/rubric.yaml'"),
    'folders': ('    import os\n    os.listdir("/tmp")', 'Permission denied'),
    'environment': (
        '    import os\n    open(f"/proc/{os.getppid()}/environ")',
        'Permission denied',
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
    'tmp': ('    open("/tmp/forged", "w")', "Permission denied: '/tmp/forged'"),
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
    'json': ('    print(\'{"score": 10}\')\n    return 1, 1, 1', 'control returned 3 values'),
    'result': ('    return float("inf"), 0', 'not finite'),
}
"""What submissions do, and what is told of it; the run goes on without them."""

ENDS = {
    'exit': ('    import os\n    os._exit(0)', 'ended its process with exit status 0'),
    'loading': ('    pass\nimport os\nos._exit(3)', 'ended its process with exit status 3'),
    'signal': ('    import os\n    os.kill(os.getpid(), 9)', 'killed by SIGKILL'),
    'crash': ('    import ctypes\n    ctypes.string_at(0)', 'killed by SIGSEGV'),
    'connection': ('    import os\n    os.write(3, bytes(range(99)))', 'on its connection'),
    'answers': (
        '    import os, struct\n'
        '    for _ in range(9): os.write(3, struct.pack("<I4s", 4, b"full"))\n'
        '    os.close(3)',
        'in a way that makes no sense',
    ),
    'files': (
        '    import time\n    for k in range(2000): open(str(k), "w").close()\n    time.sleep(9)',
        'wrote more than 64 MB or 1000 files',
    ),
}
"""The same of what ends the run."""

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
    'disk': (
        '    for k in range(99): open(str(k), "wb").write(bytes(2**23))\n    while True: pass',
        'wrote more than 64 MB',
    ),
    'large file': ('    open("x", "wb").write(bytes(2**25))', 'File too large'),
    'message': ('    raise OSError("x" * 10**5)', 'OSError'),
}


def is_named(box, body, told, tmp_path):
    """See that a submission is told of, that nothing is left of it, and that others run on."""
    (tmp_path / 'rubric.yaml').write_text('secret')
    head = f'RUBRIC = {str(tmp_path / "rubric.yaml")!r}\ndef control(i, n, poses, t):\n'

    done = run(box, f'{head}{body}\n')

    assert told.format(folder=tmp_path) in done.failure.message
    children = psutil.Process().children(recursive=True)
    assert not [one for one in children if one.ppid() != psutil.Process().pid]
    fair = run(box, STILL)
    assert same(fair.run, simulate(still, **SHORT.arguments))
    return done


@pytest.mark.parametrize('name', RUNS_ON)
def test_what_a_submission_must_not_do_fails_and_is_told(box, tmp_path, name):
    assert is_named(box, *RUNS_ON[name], tmp_path).is_complete
    assert not Path('/tmp/forged').exists()


@pytest.mark.parametrize('name', ENDS)
def test_a_submission_that_ends_its_process_ends_its_run_alone(box, tmp_path, name):
    assert not is_named(box, *ENDS[name], tmp_path).is_complete


@pytest.mark.nightly
@pytest.mark.parametrize('name', SLOW)
def test_a_submission_that_takes_too_much_is_ended(box, tmp_path, name):
    is_named(box, *SLOW[name], tmp_path)


def test_an_endless_loop_is_told_with_its_line(box):
    script = 'def control(i, n, poses, t):\n    while t > 0:\n        pass\n    return 0, 0\n'

    failure = run(box, script, times=Times(0.3, 4.0)).failure

    assert failure.message == 'control has not returned for 0.3 s'
    assert (failure.line, failure.robot, failure.t) in ((2, 1, 0.2), (3, 1, 0.2))
    assert failure.around[0] == 'def control(i, n, poses, t):'


def test_forged_modules_and_streams_are_those_of_the_submission_alone(box):
    script = (
        'import sys, threading\nimport numpy as np\nimport setcmas_ctrl.control.saturation as s\n'
        'np.hypot = np.maximum = np.asarray = s.saturate = None\nsys.stdout = sys.stderr = None\n'
        'def forge():\n    while True: pass\nthreading.Thread(target=forge, daemon=True).start()\n'
    )

    assert same(run(box, script + STILL).run, run(box, STILL).run)


def test_a_submission_may_write_in_its_home_that_is_new_for_each(box):
    script = 'import os\nassert not os.path.exists("log")\nlog = open("log", "w")\n'
    script += 'open(os.path.expanduser("~/other"), "w").write("x" * 99)\n'

    for _ in range(2):
        done = run(box, f'{script}{STILL}', Scenario('one', (), {'duration': 1.0}))
        assert done.failure is None


def test_a_box_whose_process_was_killed_goes_on_with_another(box):
    run(box, STILL)
    box._process.send_signal(signal.SIGKILL)
    box._process.wait()

    assert run(box, STILL).failure is None
