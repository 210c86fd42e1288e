"""Rendered pictures of tags at known places: perspective, distortion, blur, noise, light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from setcmas_expe.camera.camera_file import CameraFile, RobotTags
from setcmas_expe.camera.floor_projection import FloorProjection
from setcmas_expe.camera.tag_detection import MARGIN, MODULES, Picture, tag_family
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import needs

with needs('camera'):
    import cv2

Greys = NDArray[np.float32]

_TEXTURE_PX = 8
_FINER = 3
"""How many times finer than a pixel tags are drawn, along each axis."""
_BLUR_STEPS = 5
_FLOOR_GREY, _BLACK, _WHITE = 120, 25, 230


@dataclass(frozen=True)
class PictureQuality:
    """Faults of a picture.

    Attributes:
        noise: Standard deviation of a pixel in grey levels.
        exposure: Time in s during which moving tags blur.
        light: Brightness at the right edge relative to the left edge; 1 is even light.
    """

    noise: float = 4.0
    exposure: float = 0.01
    light: float = 0.6


@dataclass(frozen=True)
class PlacedTag:
    """A tag: its number, x, y in m, heading in rad, and velocities in m/s and rad/s.

    Attributes:
        scale: Its size relative to what it should be.
        lift: Its height in m above what it should be.
        covered: Grey level of what hides its middle, 255 for glare; None if nothing does.
    """

    number: int
    x: float
    y: float
    heading: float
    vx: float = 0.0
    vy: float = 0.0
    turn: float = 0.0
    scale: float = 1.0
    lift: float = 0.0
    covered: float | None = None

    def after(self, t: float) -> tuple[float, float, float]:
        """Return x, y and heading after t s."""
        return self.x + t * self.vx, self.y + t * self.vy, self.heading + t * self.turn


class PictureRenderer:
    """Renders pictures of one camera; the floor and its tags are rendered once."""

    def __init__(
        self, projection: FloorProjection, file: CameraFile, quality: PictureQuality, seed: int
    ) -> None:
        self._projection = projection
        self._tags = file.tags
        self._quality = quality
        self._random = np.random.default_rng(seed)
        width, height = projection.camera.lens.size
        self._light = np.linspace(1.0, quality.light, width, dtype=np.float32)
        self._floor: Greys = np.full((height, width), _FLOOR_GREY, np.float32) * self._light
        on_floor = RobotTags(file.tags.size, 0.0)
        for number, (x, y) in file.floor_tags.items():
            self._draw(self._floor, PlacedTag(number, x, y, 0.0), on_floor)
        self._noise = self._random.normal(0, quality.noise, (height + 64, width + 64))
        self._noise = self._noise.astype(np.float32)

    def picture(self, tags: Sequence[PlacedTag], brightness: float = 1.0) -> Picture:
        """Return a picture of robots' tags, grey, shape (height, width).

        The tags are where they are in the middle of the exposure.
        """
        picture = self._floor.copy()
        for tag in tags:
            size, height = self._tags.size * tag.scale, self._tags.height + tag.lift
            self._draw(picture, tag, RobotTags(size, height))
        if brightness != 1.0:
            picture *= brightness
        height, width = picture.shape
        y, x = self._random.integers(64, size=2)
        picture += self._noise[y : y + height, x : x + width]
        grey: Picture = cv2.convertScaleAbs(np.maximum(picture, 0))
        return grey

    def _draw(self, picture: Greys, tag: PlacedTag, kind: RobotTags) -> None:
        """Draw a tag into a picture, with the mean of several moments of the exposure."""
        half = self._quality.exposure / 2
        is_moving = bool(tag.vx or tag.vy or tag.turn)
        moments = np.linspace(-half, half, _BLUR_STEPS) if is_moving else np.zeros(1)
        corners = [self._corners(tag.after(float(t)), kind) for t in moments]
        last = np.array(picture.shape[::-1]) - 1
        low = np.clip(np.floor(np.min(corners, (0, 1))) - 2, 0, last).astype(int)
        high = np.clip(np.ceil(np.max(corners, (0, 1))) + 3, 0, last + 1).astype(int)
        if (high - low < 2).any():
            return
        layers = [_warped(tag.number, own - low, high - low) for own in corners]
        # The grey of the tag times its coverage, and the coverage.
        colour, cover = np.mean(layers, axis=0)
        part = picture[low[1] : high[1], low[0] : high[0]]
        part *= 1 - cover
        part += colour * self._light[low[0] : high[0]]
        if tag.covered is not None:
            middle = np.mean(corners, (0, 1)).round().astype(int).tolist()
            radius = int(0.3 * (high - low).max())
            cv2.circle(picture, middle, radius, tag.covered, cv2.FILLED)

    def _corners(self, pose: tuple[float, float, float], kind: RobotTags) -> Floats:
        """Return the pixels (4, 2) of the corners of a tag with its white margin."""
        x, y, heading = pose
        half = kind.size * (0.5 + MARGIN / MODULES)
        turned = half * np.exp(1j * heading) * np.array([1 + 1j, 1 - 1j, -1 - 1j, -1 + 1j])
        points = np.column_stack([x + turned.real, y + turned.imag, np.full(4, kind.height)])
        return self._projection.pixels(points)


def _warped(number: int, corners: Floats, size: NDArray[np.int64]) -> tuple[Greys, Greys]:
    """Return a tag's grey times its coverage, and its coverage, in a part of a picture.

    Args:
        number: The tag.
        corners: Pixels (4, 2) of its corners in the part.
        size: Width and height of the part in px.
    """
    texture = _texture(number)
    side = len(texture)
    # The centre of a pixel has whole coordinates; its edges are half a pixel away.
    edges = np.array([[0, 0], [side, 0], [side, side], [0, side]]) - 0.5
    places = (corners + 0.5) * _FINER - 0.5
    turn = cv2.getPerspectiveTransform(edges.astype(np.float32), places.astype(np.float32))
    fine = (int(size[0]) * _FINER, int(size[1]) * _FINER)
    shape = (int(size[0]), int(size[1]))
    layers = cv2.warpPerspective(texture, turn, fine, flags=cv2.INTER_LINEAR)
    drawn = np.asarray(cv2.resize(layers, shape, interpolation=cv2.INTER_AREA), np.float32)
    return drawn[:, :, 0], drawn[:, :, 1]


@lru_cache(maxsize=64)
def _texture(number: int) -> Greys:
    """Return a tag with its white margin: grey and coverage, shape (side, side, 2)."""
    bits = cv2.aruco.generateImageMarker(tag_family(), number, MODULES)
    modules = np.pad(bits, MARGIN, constant_values=255)
    grey = np.where(modules > 0, _WHITE, _BLACK).astype(np.float32)
    grey = grey.repeat(_TEXTURE_PX, 0).repeat(_TEXTURE_PX, 1)
    return np.dstack([grey, np.ones_like(grey)])
