"""Robots, motion capture and laptop on machines of their own, without multicast."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

from network_namespaces import UDP_ONLY, Network
from rehearsal import Rehearsal
from ros_peer import Peer

from setcmas_expe.doctor.discovery_server import PORT

RELAY = Path(__file__).parent / 'setcmas_expe' / 'scripts' / 'mocap_relay.py'
GOES = 0.07  # m/s
PEERS, SERVER = 'static peers', 'discovery server'
_SAMPLES = 1000  # of a robot's truth, at 50 Hz


@contextlib.contextmanager
def running(command, log: Path):
    with log.open('wb') as file, subprocess.Popen(command, stdout=file, stderr=file) as process:
        try:
            yield process
        finally:
            process.terminate()


def roll_after_the_laptop_is_cut_off(
    way: str, nb_robots: int, domain: int, folder: Path
) -> list[float]:
    """Return how far (m) each of the robots rolls; the laptop finds them in one of two ways."""
    os.environ.update(UDP_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET')
    with Network('mocap', 'laptop', 'robots') as network, contextlib.ExitStack() as stack:
        laptop, addresses = network.addresses['laptop'], network.addresses
        lab = folder / 'lab.yaml'
        if way == PEERS:
            peers = f'{addresses["mocap"]}, {addresses["robots"]}'
            lab.write_text(f'network: {{static_peers: [{peers}]}}')
        else:
            lab.write_text(f"network: {{discovery_server: '{laptop}:{PORT}'}}")
            server = [
                sys.executable,
                '-m',
                'setcmas_expe.doctor.discovery_server',
                '--address',
                laptop,
            ]
            command = network.command('laptop', server)
            stack.enter_context(running(command, folder / 'server.txt'))
            os.environ['ROS_DISCOVERY_SERVER'] = f'{laptop}:{PORT}'
        # Its motion capture is of another kind, so that robots and poses are on two machines.
        robots = [sys.executable, '-m', 'setcmas_expe.emulation.emulated_lab', '--mocap', 'vicon']
        robots += ['--nb-robots', str(nb_robots)]
        mocap = ['env', f'ROS_STATIC_PEERS={addresses["robots"]}']  # it sees the truth there
        mocap += [sys.executable, str(RELAY), str(nb_robots)]
        for machine, command in (('robots', robots), ('mocap', mocap)):
            command = network.command(machine, command)
            stack.enter_context(running(command, folder / f'{machine}.txt'))
        with network.on('robots'):
            peer = stack.enter_context(Peer(domain))
        os.environ.pop('ROS_DISCOVERY_SERVER', None)  # the lab file has it
        experiment = Rehearsal(
            peer,
            folder,
            *('--vnom', '0.1', '--lab', str(lab)),
            nb_robots=nb_robots,
            before=network.command('laptop', []),
            lab=(),
        )
        stack.enter_context(experiment)
        experiment.let_go(GOES)
        network.cut('laptop')
        fault = time.time()  # the newest truth may be old: a busy peer lags behind
        return [experiment.wait_for_stop(fault, robot).metres for robot in experiment.truth]


_SHIFT = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <time.h>
int clock_gettime(clockid_t clock, struct timespec *now) {
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
    int status = real(clock, now);
    if (clock == CLOCK_REALTIME) now->tv_sec += %(ahead)d;
    return status;
}
int pthread_cond_timedwait(pthread_cond_t *c, pthread_mutex_t *m, const struct timespec *until) {
    static int (*real)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
    if (!real) real = dlvsym(RTLD_NEXT, "pthread_cond_timedwait", "GLIBC_2.3.2");
    struct timespec here = *until;  /* the kernel has the true clock */
    if (here.tv_sec > 1000000000) here.tv_sec -= %(ahead)d;
    return real(c, m, &here);
}
"""


def clock_ahead(seconds: int, folder: Path) -> list[str]:
    """Return the start of a command whose process sees a clock that is ahead."""
    library = folder / 'shift.so'
    source = library.with_suffix('.c')
    source.write_text(_SHIFT % {'ahead': seconds})
    subprocess.run(
        ['cc', '-shared', '-fPIC', '-o', library, source, '-ldl', '-lpthread'], check=True
    )
    return ['env', f'LD_PRELOAD={library}']


def record_robots_with_another_clock(
    ahead: int, options: list[str], nb_robots: int, domain: int, folder: Path
) -> Path:
    """Return the bag of an experiment whose robots and cameras have a clock that is ahead (s)."""
    os.environ.update(UDP_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE='SUBNET')
    bag = folder / 'bag'
    with Network('laptop', 'robots') as network, contextlib.ExitStack() as stack:
        lab = folder / 'lab.yaml'
        lab.write_text(
            f'network: {{static_peers: [{network.addresses["robots"]}]}}\n'
            'timeouts: {pose: 2, command: 2, pause: 2}\n'
        )
        robots = [*clock_ahead(ahead, folder), sys.executable]
        robots += ['-m', 'setcmas_expe.emulation.emulated_lab', '--nb-robots', str(nb_robots)]
        command = network.command('robots', [*robots, *options])
        stack.enter_context(running(command, folder / 'robots.txt'))
        with network.on('robots'):
            peer = stack.enter_context(Peer(domain))
        peers = ['env', f'ROS_STATIC_PEERS={network.addresses["robots"]}']
        record = [*peers, sys.executable, '-m', 'setcmas_tools.bags.recorder', '-o', str(bag)]
        command = network.command('laptop', record)
        recorder = stack.enter_context(running(command, folder / 'recorder.txt'))
        experiment = Rehearsal(
            peer,
            folder,
            *('--lab', str(lab), '--without-motion-check'),
            nb_robots=nb_robots,
            before=network.command('laptop', []),
            lab=(),
        )
        with experiment:
            experiment.let_go(GOES)
            began = len(experiment.truth[1])
            peer.wait_for(lambda: len(experiment.truth[1]) > began + _SAMPLES)
        recorder.terminate()
        recorder.wait()
    return bag
