"""Measures poses of tags in rendered pictures against the truth, and the cost of finding them.

A camera of 1920 x 1080 px is 3 m above the floor; tags of 120 mm are 0.2 m above it. Lens and pose
of the camera are known exactly. Run in the environment that setcmas is installed in:

    python benchmarks/camera.py [--pictures 40] [--seed 3]
"""

import argparse
import math
import time

import cv2
import numpy as np
from tabulate import tabulate

from setcmas_expe.camera.camera_file import Camera, CameraFile, CameraPose, Lens, RobotTags
from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_expe.camera.picture_rendering import PictureQuality, PictureRenderer, PlacedTag
from setcmas_expe.camera.tag_detection import TagDetector, tag_poses

X, Y = 2.0, 1.15
"""Half the sides in m of the part of the arena that one camera sees."""
APART_M = 0.25
FLOOR_TAGS = {501: (-1.9, -1.1), 502: (1.9, -1.1), 503: (1.9, 1.1), 504: (-1.9, 1.1)}
RATE_HZ = 30


def scene():
    """Return the content of a camera file, with one camera that looks straight down."""
    down = tuple(cv2.Rodrigues(np.diag([1.0, -1.0, -1.0]))[0].ravel().tolist())
    distortion = (-0.1, 0.02, 0.0005, -0.0004, 0.0)
    lens = Lens((1920, 1080), (1050.0, 1050.0), (959.5, 539.5), distortion, 0.0)
    camera = Camera('ceiling', lens, CameraPose((0.0, 0.0, 3.0), down, 0.0))
    return CameraFile(RobotTags(0.12, 0.2), FLOOR_TAGS, (camera,))


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


def measured(nb_robots, speed, nb_pictures, seed):
    """Return a row of the table."""
    file, random = scene(), np.random.default_rng(seed)
    projection = FloorProjection(file.cameras[0])
    renderer = PictureRenderer(projection, file, PictureQuality(), seed)
    detector = TagDetector()
    errors, latencies, cpu = [], [], 0.0
    for _ in range(nb_pictures):
        tags = fleet(random, nb_robots, speed)
        picture = renderer.picture(tags)
        begin, cpu_begin = time.perf_counter(), time.process_time()
        corners, _ = detector.corners(picture)
        poses, _ = tag_poses(projection, file.tags, corners, nb_robots)
        latencies.append(time.perf_counter() - begin)
        cpu += time.process_time() - cpu_begin
        errors += [error(poses[tag.number], tag) for tag in tags if tag.number in poses]
    found = np.array(errors) * [1e3, 180 / math.pi]
    rms, worst = np.sqrt((found**2).mean(axis=0)), found.max(axis=0)
    missed = nb_robots * nb_pictures - len(errors)
    cost = (1e3 * np.median(latencies), cpu / nb_pictures * RATE_HZ)
    return nb_robots, speed, rms[0], worst[0], rms[1], worst[1], missed, *cost


def error(pose, tag):
    """Return the errors of a pose in m and rad."""
    turned = math.remainder(pose.heading - tag.heading, math.tau)
    return math.hypot(pose.x - tag.x, pose.y - tag.y), abs(turned)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--pictures', type=int, default=40)
    parser.add_argument('--seed', type=int, default=3)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    cases = [(1, 0.2), (8, 0.0), (8, 0.2), (20, 0.2)]
    rows = [measured(*case, args.pictures, args.seed) for case in cases]
    headers = [
        'robots', 'm/s', 'RMS mm', 'worst mm', 'RMS deg', 'worst deg', 'missed', 'latency ms',
        f'cores at {RATE_HZ} Hz',
    ]  # fmt: skip
    print(tabulate(rows, headers, floatfmt='.2f'))


if __name__ == '__main__':
    main()
