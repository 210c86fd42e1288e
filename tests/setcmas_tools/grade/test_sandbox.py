import os
import resource
import signal
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import psutil
import pytest
from hostile_submissions import ENDS, RUNS_ON, SLOW, WRITES
from sandboxes import forbid_mounts

from setcmas_ctrl import network
from setcmas_ctrl.scripts.loader import ALGORITHMS
from setcmas_tools import simulate
from setcmas_tools.grade.rubric_scenarios import CTC, MarkedScenario
from setcmas_tools.grade.sandbox import SandboxRunner, Times, sandbox
from setcmas_tools.offline.child_channel import MachineError
from setcmas_tools.offline.host import Host
from setcmas_tools.offline.kernel_confinement import obstacle
from setcmas_tools.scenario.scenario import Scenario

pytestmark = pytest.mark.skipif(bool(obstacle()), reason=obstacle())

FLEET = Scenario.of('', nb_robots=5, duration=8.0)
LOSSY = FLEET.replace(graph='ring', loss=0.2, noise=0.01)
SHORT = Scenario.of('', nb_robots=2, duration=1.0)
STILL = 'def control(i, n, poses, t):\n    return 0.25, 0\n'
TIMES = Times(1.0, 4.0)
LAWS = ('consensus', 'nav_wp', 'traj_tracking', 'leader_follower_formation')


@pytest.fixture(scope='session')
def host(tmp_path_factory):
    with sandbox(tmp_path_factory.mktemp('sandbox'), confined=True) as one:
        yield one


def run(host, script, scenario=SHORT, times=TIMES, **others):
    files = {'law.py': script} if isinstance(script, bytes) else {'law.py': script.encode()}
    return SandboxRunner(host, 'law.py', files, times, **others)(
        MarkedScenario('one', (), scenario)
    )


def still(i, n, poses, t):
    return 0.25, 0


def same(one, other):
    pairs = zip(vars(one.table).values(), vars(other.table).values(), strict=True)
    return all(np.array_equal(*pair) for pair in pairs)


@pytest.mark.parametrize('law', [*LAWS, 'leader_follower_distance_formation'])
def test_a_law_in_a_sandbox_drives_as_it_does_offline_to_the_last_bit(host, law):
    file = ALGORITHMS.file(law)

    done = run(host, file.read_bytes(), FLEET)

    assert same(done.run, simulate(FLEET, algo=file))
    assert done.failure is None


def test_a_law_in_a_sandbox_hears_and_draws_as_it_does_offline(host, tmp_path):
    source = b'import random\nimport numpy as np\nfrom setcmas_ctrl import network\nK = 1\n'
    source += b'rng = np.random.default_rng()\nother = random.Random()\n'
    source += b'def control(i, n, poses, t):\n'
    source += b'    vx = 0.1 * rng.random() * other.random()\n'
    source += b'    return vx, K * len(network.neighbours()) * poses[0, i - 1]\n'
    (tmp_path / 'law.py').write_bytes(source)
    scenario = LOSSY.replace(seed=3, set={'K': -0.1})

    own = simulate(scenario, algo=tmp_path / 'law.py')

    assert same(run(host, source, scenario).run, own)


TALKING = """
from setcmas_ctrl import network
def control(i, n, poses, t):
    received = network.received()
    network.send({'x': poses[0, i - 1], 'v': [i, t]})
    if round(t, 1) == 1.0:
        1 / 0
    total = sum(one.age * one.value['x'] + one.value['v'][0] for one in received.values())
    return 0.02 * total, 0.1 * len(received)
"""


@pytest.mark.parametrize('scenario', [LOSSY.replace(delay=0.15), FLEET.replace(duration=3.0)])
def test_a_law_in_a_sandbox_uses_messages_as_it_does_offline(host, tmp_path, scenario):
    (tmp_path / 'law.py').write_text(TALKING)

    own = simulate(scenario, algo=tmp_path / 'law.py', warn=str)
    done = run(host, TALKING, scenario)

    assert same(done.run, own)
    assert 'ZeroDivisionError' in done.failure.message
    assert [(one.t, one.robot, one.value['x']) for one in done.run.messages] == [
        (one.t, one.robot, one.value['x']) for one in own.messages
    ]
    assert done.run.record.links == own.record.links


def test_what_cannot_be_sent_is_an_error_in_a_sandbox_too(host):
    source = 'from setcmas_ctrl import network\ndef control(i, n, poses, t):\n'
    done = run(host, source + '    network.send([[1], 2])\n    return 0, 0\n')

    assert 'law.py, line 3: TypeError: network.send got [[1], 2]' in done.failure.message
    assert not done.run.messages


def test_a_condition_in_a_sandbox_gets_values(host, tmp_path):
    source = 'def ctc(pos, last_pos, t, *, value, last_value):\n'
    source += '    return value is not None and (not last_value or value > last_value + 1)\n'
    (tmp_path / 'law.py').write_text(source)

    def law(i, n, poses, t):
        network.send(t * i)
        return 0.1 * len(network.received()), 0

    scenario = SHORT.replace(algo=law, event_triggered=True, duration=4.0)
    own = simulate(scenario, ctc=tmp_path / 'law.py')
    done = run(host, source, scenario, function=CTC)

    assert same(done.run, own)
    assert done.run.record.robots[1].sent < done.run.record.robots[2].sent


def test_random_numbers_repeat_and_differ_between_robots(host):
    source = 'import random\ndef control(i, n, poses, t):\n    return random.random(), 0\n'

    first, again = (run(host, source).run for _ in range(2))

    assert same(first, again)
    assert not np.array_equal(first.table.of(1).v, first.table.of(2).v)


@pytest.mark.parametrize('speeds', [False, True])
def test_a_condition_in_a_sandbox_triggers_as_it_does_offline(host, tmp_path, speeds):
    arguments = 'pos, vit, last_pos, last_vit, t' if speeds else 'pos, last_pos, t'
    source = f'def ctc({arguments}):\n    return abs(pos - last_pos).sum() > 0.2\n'
    (tmp_path / 'law.py').write_text(source)
    scenario = FLEET.replace(algo='consensus', event_triggered=True)

    own = simulate(scenario, ctc=tmp_path / 'law.py')

    assert same(run(host, source, scenario, function=CTC).run, own)


MESSAGES = {
    True: {'environ': 'No such file', 'tmp': 'Read-only file system'},
    False: {'environ': 'Permission denied', 'tmp': 'Permission denied'},
}


def is_named(host, body, message, tmp_path):
    """Check that a submission is reported, leaves nothing behind, and disturbs no other."""
    (tmp_path / 'rubric.yaml').write_text('secret')
    head = f'RUBRIC = {str(tmp_path / "rubric.yaml")!r}\ndef control(i, n, poses, t):\n'

    done = run(host, f'{head}{body}\n')

    message = message.format(folder=tmp_path, **MESSAGES[host.has_private_mounts])
    assert message in done.failure.message
    children = psutil.Process().children(recursive=True)
    assert not [one for one in children if one.ppid() != psutil.Process().pid]
    fair = run(host, STILL)
    assert same(fair.run, simulate(SHORT, algo=still))
    return done


@pytest.mark.parametrize('name', RUNS_ON)
def test_forbidden_actions_fail_and_are_reported(host, tmp_path, name):
    assert is_named(host, *RUNS_ON[name], tmp_path).is_complete
    assert not Path('/tmp/forged').exists()


@pytest.mark.parametrize('name', ENDS)
def test_a_submission_that_ends_its_process_ends_its_run_alone(host, tmp_path, name):
    assert not is_named(host, *ENDS[name], tmp_path).is_complete


@pytest.mark.parametrize('name', WRITES)
@pytest.mark.parametrize('mounts', [True, pytest.param(False, marks=pytest.mark.nightly)])
def test_a_submission_cannot_fill_the_disk(tmp_path, mounts, name):
    body, message = WRITES[name]
    with sandbox(tmp_path, confined=True) as host:
        if not mounts:
            forbid_mounts(host, tmp_path)
        done = run(host, f'def control(i, n, poses, t):\n{body}\n')
        is_full = host.has_private_mounts

    assert (message if is_full else 'wrote more than 64 MB') in done.failure.message


def test_the_file_of_current_calls_counts_too(host):
    script = (
        'import os, time\ndef control(i, n, poses, t):\n    os.write(4, bytes(2**24))\n'
        '    time.sleep(9 * (i == n))\n    return 0, 0\n'
    )

    done = run(host, script, SHORT.replace(nb_robots=6))

    assert 'wrote more than 64 MB' in done.failure.message


def test_all_robots_together_have_the_processor_time_of_one(host):
    script = (
        'import os, struct\ndef control(i, n, poses, t):\n'
        '    if i < n:\n        os.write(3, struct.pack("<Qdd", 16, 0, 0))\n'
        '    while True: pass\n'
    )

    done = run(host, script, SHORT.replace(nb_robots=9), Times(9.0, 2.0))

    assert done.failure.message == 'the script took too much processor time'


@pytest.mark.nightly
@pytest.mark.parametrize('name', SLOW)
def test_a_submission_that_takes_too_much_is_ended(host, tmp_path, name):
    is_named(host, *SLOW[name], tmp_path)


def test_an_endless_loop_is_reported_with_its_line(host):
    script = 'def control(i, n, poses, t):\n    while t > 0:\n        pass\n    return 0, 0\n'

    failure = run(host, script, times=Times(0.3, 4.0)).failure

    assert failure.message == 'control has not returned for 0.3 s'
    assert (failure.line, failure.robot, failure.t) in ((2, 1, 0.2), (3, 1, 0.2))
    assert failure.around[0] == 'def control(i, n, poses, t):'


def test_forged_modules_and_streams_are_those_of_the_submission_alone(host):
    script = (
        'import sys\nimport numpy as np\nimport setcmas_ctrl.control.saturation as s\n'
        'vars(np).update(hypot=None, maximum=None, asarray=None)\n'
        's.saturate = sys.stdout = sys.stderr = None\n'
    )

    assert same(run(host, script + STILL).run, run(host, STILL).run)


def test_a_submission_may_write_in_its_home_that_is_new_for_each(host):
    script = 'import os\nassert not os.path.exists("log")\nlog = open("log", "w")\n'
    script += 'open(os.path.expanduser("~/other"), "w").write("x" * 99)\n'

    for _ in range(2):
        done = run(host, f'{script}{STILL}', Scenario.of('', duration=1.0))
        assert done.failure is None


def test_a_sandbox_whose_process_was_killed_goes_on_with_another(host):
    run(host, STILL)
    host.process.send_signal(signal.SIGKILL)
    host.process.wait()

    assert run(host, STILL).failure is None


def test_time_in_which_other_programs_have_the_cores_does_not_count(host, monkeypatch):
    script = 'import time\ndef control(i, n, poses, t):\n    time.sleep(0.15)\n    return 0, 0\n'
    assert 'longer than 1 s' in run(host, script, times=Times(1.0, 1.0)).failure.message

    waiting = 'setcmas_tools.grade.sandbox.times_s'
    monkeypatch.setattr(waiting, lambda _: (0.0, time.monotonic()))

    assert run(host, script, times=Times(1.0, 1.0)).failure is None


FAULTS = {
    'no process': lambda host: limit_open_files(host, 4),
    'host killed': lambda host: host.process.kill(),
    'process killed': lambda host: os.kill(next(iter(host._children)).process, 9),
}
"""What goes wrong with a machine while a submission is graded."""


def limit_open_files(host, most):
    """Keep a host from starting a process, as a user's limit of processes does."""
    resource.prlimit(host.process.pid, resource.RLIMIT_NOFILE, (most, 4096))


# A process that is killed twice after it began may have killed itself.
@pytest.mark.parametrize(
    ('fault', 'times'), [*((fault, 1) for fault in FAULTS), ('no process', 2), ('host killed', 2)]
)
def test_a_fault_of_the_machine_is_not_the_fault_of_a_submission(host, monkeypatch, fault, times):
    run(host, STILL)
    begin, faults = Host.begin, iter([FAULTS[fault]] * times)

    def disturbed(self, *args):
        if len(self._children) == 1:  # the process of robot 1 runs already
            next(faults, lambda _: None)(self)
        try:
            return begin(self, *args)
        finally:
            with suppress(ProcessLookupError):
                limit_open_files(self, 1024)

    monkeypatch.setattr(Host, 'begin', disturbed)
    if times == 2:
        with pytest.raises(MachineError, match='this computer cannot run'):
            run(host, STILL)
    assert run(host, STILL).failure is None


def test_a_trusted_script_that_stops_the_process_of_the_host_costs_nothing(tmp_path, monkeypatch):
    continue_it, stops = Host._continue, iter(range(3))

    def continue_then_stop(self):
        continue_it(self)
        if next(stops, None) is not None:
            self.process.send_signal(signal.SIGSTOP)  # as another robot's script, before the order

    script = 'import os\nos.kill(os.getppid(), 19)\n' + STILL
    monkeypatch.setattr(Host, '_continue', continue_then_stop)
    with sandbox(tmp_path, confined=False) as host:
        for _ in range(2):
            assert run(host, script).failure is None
    assert not [*stops]
