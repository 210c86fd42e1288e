"""A camera over a floor with tags, and its short recorded video of robots with known poses.

The pictures in data/camera were rendered with lens distortion, noise, uneven light and the blur
of robots at 0.2 m/s, 15 a second; poses.csv has the true pose of each robot in each.
"""

import csv
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

cv2 = pytest.importorskip('cv2')

from setcmas_expe.mocap.camera_file import (  # noqa: E402
    Camera,
    CameraFile,
    CameraPose,
    Lens,
    RobotTags,
)

FOLDER = Path(__file__).parent / 'data/camera'
VIDEO = str(FOLDER / '%02d.jpg')
FLOOR_TAGS = {501: (-0.8, -0.5), 502: (0.8, -0.5), 503: (0.8, 0.5), 504: (-0.8, 0.5)}
DISTORTION = (-0.12, 0.03, 0.0005, -0.0004, 0.0)
NO_ERROR = 0.0


def camera(x=0.0, y=0.3, tilt=0.15, name='left'):
    """Return a camera 2 m above x, y that looks at 0, 0, with its picture's top towards +y.

    The video is of the default one.
    """
    down = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])
    rotation = cv2.Rodrigues(np.array([tilt, 0.0, 0.0]))[0] @ down
    vector = cv2.Rodrigues(rotation)[0].ravel()
    lens = Lens((960, 600), (700.0, 702.0), (480.0, 300.0), DISTORTION, NO_ERROR)
    pose = CameraPose((x, y, 2.0), tuple(float(v) for v in vector), NO_ERROR)
    return Camera(name, '0', lens, pose)


def seen_at(camera, points):
    """Return the pixels (N, 2) at which a camera sees points x, y, z in m, shape (N, 3)."""
    rotation = np.array(camera.pose.rotation)
    shift = -cv2.Rodrigues(rotation)[0] @ camera.pose.position
    lens = camera.lens.matrix, np.array(camera.lens.distortion)
    return cv2.projectPoints(points, rotation, shift, *lens)[0].reshape(-1, 2)


def scene(*cameras):
    """Return the content of a camera file."""
    return CameraFile(RobotTags(0.12, 0.2), cameras or (camera(),), FLOOR_TAGS)


def pictures():
    """Return the pictures of the video, grey."""
    return [cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in sorted(FOLDER.glob('*.jpg'))]


def true_poses():
    """Return x, y in m and heading in rad of each robot by its number, a dict for each picture."""
    poses = defaultdict(dict)
    with (FOLDER / 'poses.csv').open() as file:
        for row in csv.DictReader(file):
            pose = float(row['x']), float(row['y']), float(row['heading'])
            poses[row['picture']][int(row['robot'])] = pose
    return list(poses.values())


def with_copy(picture, robot, x, y):
    """Return the first picture with a second tag of a robot at x, y in m."""
    (column, row), (to_column, to_row) = (
        seen_at(camera(), np.array([[*place, 0.2]]))[0].round().astype(int)
        for place in (true_poses()[0][robot][:2], (x, y))
    )
    half, copied = 40, picture.copy()
    copied[to_row - half : to_row + half, to_column - half : to_column + half] = picture[
        row - half : row + half, column - half : column + half
    ]
    return copied
