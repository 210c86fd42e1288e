"""Measures poses of tags in rendered pictures against the truth, and the cost of finding them.

Cameras of 1920 x 1080 px are 3 m above an arena of 4 x 3 m; tags of 120 mm are 0.2 m above it.
Pictures have lens distortion, noise, blur and uneven light; two cameras take theirs in turn. Run
in the environment that setcmas is installed in, on a quiet machine:

    python benchmarks/camera.py [--places 20] [--seed 3]
"""

import argparse
import math
import time
from dataclasses import replace

import cv2
import numpy as np
from tabulate import tabulate

from setcmas_expe.emulation.emulated_camera import PictureRenderer, PlacedTag
from setcmas_expe.mocap.camera_file import Camera, CameraFile, CameraPose, Lens, RobotTags
from setcmas_expe.mocap.camera_poses import CameraPoses

X, Y = 1.9, 1.4
"""Half the sides in m of the box in which the tags' centres are."""
APART_M = 0.25
FLOOR_TAGS = {501: (-1.9, -1.3), 502: (1.9, -1.3), 503: (1.9, 1.3), 504: (-1.9, 1.3),
              505: (0.0, -1.3), 506: (0.0, 1.3)}  # fmt: skip
RATE_HZ = 30
NB_PICTURES = 9
"""Pictures of a camera in each place."""


def camera(name, x):
    """Return a camera over x, 0 that looks straight down."""
    down = tuple(cv2.Rodrigues(np.diag([1.0, -1.0, -1.0]))[0].ravel().tolist())
    distortion = (-0.1, 0.02, 0.0005, -0.0004, 0.0)
    lens = Lens((1920, 1080), (950.0, 950.0), (959.5, 539.5), distortion, 0.0)
    return Camera(name, '', lens, CameraPose((x, 0.0, 3.0), down, 0.0))


ONE = CameraFile(RobotTags(0.12, 0.2), (camera('middle', 0.0),), FLOOR_TAGS)
TWO = replace(ONE, cameras=(camera('left', -0.4), camera('right', 0.4)))


def believed(shift=0.0, focal=1.0, height=0.2):
    """Return what a wrong calibration says of the one camera."""
    right = ONE.cameras[0]
    lens = replace(right.lens, focal=(focal * 950.0, focal * 950.0))
    pose = replace(right.pose, position=(shift, 0.0, 3.0))
    tags = replace(ONE.tags, height=height)
    return replace(ONE, tags=tags, cameras=(replace(right, lens=lens, pose=pose),))


def fleet(random, nb_robots, speed):
    """Return tags at random places, apart from each other and from the floor tags."""
    tags = []
    while len(tags) < nb_robots:
        x, y = random.uniform(-X, X), random.uniform(-Y, Y)
        others = [*FLOOR_TAGS.values(), *((tag.x, tag.y) for tag in tags)]
        if all(math.dist((x, y), other) > APART_M for other in others):
            heading = random.uniform(-math.pi, math.pi)
            vx, vy = speed * math.cos(heading), speed * math.sin(heading)
            tags.append(PlacedTag(len(tags) + 1, x, y, heading, vx, vy, 2 * speed))
    return tags


def measured(name, file, nb_robots, speed, nb_places, seed, calibrated=None):
    """Return a row of the table, and what the user is told."""
    random = np.random.default_rng(seed)
    renderers = {
        one.name: PictureRenderer(one, file, seed + index)
        for index, one in enumerate(file.cameras)
    }
    errors, latencies, cpu, told, missed = [], [], 0.0, set(), 0
    for _ in range(nb_places):
        tags = fleet(random, nb_robots, speed)
        poses = CameraPoses(calibrated or file, nb_robots)
        for step in range(NB_PICTURES * len(renderers)):
            camera = file.cameras[step % len(renderers)].name
            t = step / RATE_HZ / len(renderers)
            moved = [replace(tag, **_placed(tag.after(t))) for tag in tags]
            picture = renderers[camera].picture(moved)
            begin, cpu_begin = time.perf_counter(), time.process_time()
            found = poses.look(camera, t, picture)
            latencies.append(time.perf_counter() - begin)
            cpu += time.process_time() - cpu_begin
            told |= set(poses.news())
            errors += [error(found[tag.number], tag) for tag in moved if tag.number in found]
            missed += sum(tag.number not in found for tag in moved)
    cost = (1e3 * np.median(latencies), cpu / len(latencies) * RATE_HZ * len(renderers))
    if not errors:
        return (name, nb_robots, speed, *[math.nan] * 4, missed, *cost), told
    rms_worst = np.array(errors) * [1e3, 180 / math.pi]
    rms, worst = np.sqrt((rms_worst**2).mean(axis=0)), rms_worst.max(axis=0)
    return (name, nb_robots, speed, rms[0], worst[0], rms[1], worst[1], missed, *cost), told


def _placed(pose):
    return dict(zip(('x', 'y', 'heading'), pose, strict=True))


def error(pose, tag):
    """Return the errors of a pose in m and rad."""
    x, y, heading = pose
    return math.hypot(x - tag.x, y - tag.y), abs(math.remainder(heading - tag.heading, math.tau))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--places', type=int, default=20)
    parser.add_argument('--seed', type=int, default=3)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    cases = [
        ('one', ONE, 8, 0.0),
        ('one', ONE, 8, 0.2),
        ('two', TWO, 8, 0.0),
        ('two', TWO, 8, 0.2),
        ('one', ONE, 1, 0.2),
        ('one', ONE, 20, 0.2),
    ]
    wrong = [('moved by 20 mm', {'shift': 0.02}), ('moved by 50 mm', {'shift': 0.05}),
             ('focal length 3 % too long', {'focal': 1.03}),
             ('focal length 10 % too long', {'focal': 1.1}),
             ('tags 50 mm higher than said', {'height': 0.15}),
             ('tags 150 mm higher than said', {'height': 0.05})]  # fmt: skip
    rows = [measured(*case, args.places, args.seed) for case in cases]
    rows += [
        measured(name, ONE, 8, 0.2, args.places, args.seed, believed(**changes))
        for name, changes in wrong
    ]
    headers = [
        'cameras', 'robots', 'm/s', 'RMS mm', 'worst mm', 'RMS deg', 'worst deg', 'missed',
        'latency ms', f'cores at {RATE_HZ} Hz',
    ]  # fmt: skip
    print(tabulate([row for row, _ in rows], headers, floatfmt='.2f'))
    for (name, *_), told in rows:
        print(f'{name}: {next(iter(sorted(told)), "no warning")}')


if __name__ == '__main__':
    main()
