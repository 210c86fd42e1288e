"""A camera over a floor with tags, for tests: small pictures with known truth."""

import numpy as np
import pytest

cv2 = pytest.importorskip('cv2')

from setcmas_expe.emulation.emulated_camera import PictureRenderer  # noqa: E402
from setcmas_expe.mocap.camera_file import (  # noqa: E402
    Camera,
    CameraFile,
    CameraPose,
    Lens,
    RobotTags,
)

FLOOR_TAGS = {501: (-0.8, -0.5), 502: (0.8, -0.5), 503: (0.8, 0.5), 504: (-0.8, 0.5)}
DISTORTION = (-0.12, 0.03, 0.0005, -0.0004, 0.0)
NO_ERROR = 0.0


def camera(x=0.0, y=0.3, tilt=0.15, name='left', scale=1.0):
    """Return a camera 2 m above x, y that looks at 0, 0, with its picture's top towards +y."""
    down = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]])
    rotation = cv2.Rodrigues(np.array([tilt, 0.0, 0.0]))[0] @ down
    vector = cv2.Rodrigues(rotation)[0].ravel()
    size = (int(960 * scale), int(600 * scale))
    lens = Lens(
        size, (700.0 * scale, 702.0 * scale), (size[0] / 2, size[1] / 2), DISTORTION, NO_ERROR
    )
    pose = CameraPose((x, y, 2.0), tuple(float(v) for v in vector), NO_ERROR)
    return Camera(name, '0', lens, pose)


def scene(*cameras, size=0.12, height=0.2):
    """Return the content of a camera file."""
    return CameraFile(RobotTags(size, height), cameras or (camera(),), FLOOR_TAGS)


def renderer(file, number=0, seed=1, **options):
    """Return a renderer of one of the cameras."""
    return PictureRenderer(file.cameras[number], file, seed, **options)
