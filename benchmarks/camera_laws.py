"""Runs the classic laws in the emulated lab by camera and by Qualisys, and compares both.

Prints the distance of the robots' true ways from those of a run by Qualisys, after the shift in
time that fits best, and the stops that no fault explains. Run in the environment that setcmas is
installed in, on a quiet machine; it takes some 15 minutes:

    python benchmarks/camera_laws.py [--seconds 30] [--repeat 2] [--only consensus]
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / 'tests'))
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

from rehearsal import Rehearsal
from ros_domain import reserved_domain
from ros_peer import Peer
from tabulate import tabulate

LAWS = {
    'nav_wp': 1,
    'traj_tracking': 1,
    'consensus': 3,
    'leader_follower_formation': 3,
    'leader_follower_distance_formation': 3,
}
"""Robots of each law."""
STOPS = re.compile(r'\[pause\] paused: .*|.*emergency stop: .*')
GOES_M_S = 0.03
STEP_S = 0.1
MOST_SHIFT_S = 5.0


def ways(law, mocap, seed, seconds):
    """Run a law; return true x, y of its robots (T, N, 2) from their first motion, and stops."""
    with (
        tempfile.TemporaryDirectory() as folder,
        reserved_domain() as domain,
        Peer(domain) as peer,
    ):
        os.environ['ROS_DOMAIN_ID'] = str(domain)
        options = ('--algo', law, '--mocap', mocap, '--seed', str(seed))
        with Rehearsal(
            peer, Path(folder), *options, nb_robots=LAWS[law], lab=('--emulate',)
        ) as running:
            peer.wait_for(lambda: all(running.truth.values()))
            peer.wait_for(lambda: 'controlling robot' in running.output())
            running.press_until(lambda: all(_sets_off(one) for one in running.truth.values()))
            begin = max(_sets_off(one) for one in running.truth.values())
            peer.wait_for(lambda: running.truth[1][-1].stamp > begin + seconds, 4 * seconds)
            output = running.output()
            if STOPS.search(output):
                print(output[-2000:], file=sys.stderr)
            truth = list(running.truth.values())
    times = np.arange(begin, begin + seconds, STEP_S)
    found = [np.array([(s.stamp, s.x, s.y) for s in one]).T for one in truth]
    places = [[np.interp(times, t, axis) for axis in (x, y)] for t, x, y in found]
    return np.array(places).transpose(2, 0, 1), STOPS.findall(output)


def _sets_off(samples):
    return next((one.stamp for one in samples if one.V > GOES_M_S), None)


def distances(one, other):
    """Return RMS and largest distance in m between ways, with the shift in s that fits best."""
    most = round(MOST_SHIFT_S / STEP_S)
    count = len(one) - 2 * most
    base = one[most : most + count]

    def apart(shift):
        return np.linalg.norm(base - other[most + shift : most + shift + count], axis=2)

    shift = min(range(-most, most + 1), key=lambda shift: (apart(shift) ** 2).mean())
    return np.sqrt((apart(shift) ** 2).mean()), apart(shift).max(), shift * STEP_S


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=30.0)
    parser.add_argument('--repeat', type=int, default=2)
    parser.add_argument('--only', action='append', choices=list(LAWS))
    args = parser.parse_args()
    rows = []
    for law in args.only or LAWS:
        reference, stops = ways(law, 'qualisys', 0, args.seconds)
        rows.append((law, 'qualisys', 0.0, 0.0, 0.0, len(stops), *stops[:1]))
        for mocap, seed in [('qualisys', 1), *(('camera', seed) for seed in range(args.repeat))]:
            found, stops = ways(law, mocap, seed, args.seconds)
            rows.append((law, mocap, *distances(reference, found), len(stops), *stops[:1]))
            print(rows[-1], flush=True)
    headers = ['law', 'mocap', 'RMS m', 'most m', 'shift s', 'stops', 'first stop']
    print(tabulate(rows, headers, floatfmt='.3f'))


if __name__ == '__main__':
    main()
