"""Checks of cameras: rate, latency, light, floor tags, and what accuracy to expect where."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from setcmas_expe.camera.camera_file import Camera, CameraFile, load_cameras
from setcmas_expe.camera.camera_poses import MOST_SHIFT_M
from setcmas_expe.camera.floor_projection import Accuracy, FloorProjection, expected_accuracy
from setcmas_expe.camera.picture_sources import open_source
from setcmas_expe.camera.tag_detection import Picture, TagDetector
from setcmas_expe.doctor.findings import NOTE, OK, PROBLEM, Finding
from setcmas_simu.arrays import Floats
from setcmas_simu.errors import SetcmasError
from setcmas_simu.robots.arena import Arena

_WATCHED_S = 3.0
_FEWEST_HZ = 15.0
_LATEST_S = 0.15
_FEWEST_PX = 24.0
"""Side in px from which a tag is found in every picture, if it moves at 0.2 m/s, too."""
_LEAST_CONTRAST = 60.0
_WORST_M, _WORST_RAD = 0.03, np.radians(3.0)
_GRID = 25


@dataclass
class _View:
    """What a camera showed."""

    projection: FloorProjection
    times: list[float] = field(default_factory=list)
    latencies: list[float] = field(default_factory=list)
    picture: Picture | None = None
    corners: dict[int, Floats] = field(default_factory=dict)


def camera_findings(path: Path, arena: Arena) -> list[Finding]:
    """Return what is found about the cameras of a file, and write a picture for each beside it.

    Raises:
        SetcmasError: The file has a mistake, or a camera cannot be opened or is not calibrated.
    """
    file = load_cameras(path)
    if not file.cameras:
        raise SetcmasError(f"'{path}' has no camera: run setcmas camera with --calibrate lens")
    views = [_watched(camera) for camera in file.cameras]
    across = np.linspace(arena.xmin, arena.xmax, _GRID)
    up = np.linspace(arena.ymin, arena.ymax, _GRID)
    places = [(float(x), float(y)) for y in up for x in across]
    expected = [_best(views, file, x, y) for x, y in places]
    findings = list(chain.from_iterable(_of_camera(view, file) for view in views))
    findings += _of_arena(expected)
    errors = np.array([1e3 * one.position if one else np.nan for one in expected])
    for view in views:
        picture = path.with_name(f'{path.stem}_{view.projection.camera.name}.png')
        _draw(view, across, up, errors.reshape(_GRID, _GRID), picture)
        findings.append(Finding(OK, view.projection.camera.name, f'see {picture}'))
    return findings


def _watched(camera: Camera) -> _View:
    view = _View(FloorProjection(camera))
    source = open_source(camera.source, camera.lens.size)
    end = time.monotonic() + _WATCHED_S
    while time.monotonic() < end and (shot := source.read()):
        view.times.append(shot[0])
        view.latencies.append(time.time() - shot[0])
        view.picture = shot[1]
        view.corners |= TagDetector().corners(shot[1])[0]
    return view


def _best(views: list[_View], file: CameraFile, x: float, y: float) -> Accuracy | None:
    found = [expected_accuracy(view.projection, file.tags, x, y) for view in views]
    return min(filter(None, found), key=lambda one: one.position, default=None)


def _of_camera(view: _View, file: CameraFile) -> list[Finding]:
    name = view.projection.camera.name
    if view.picture is None:
        return [Finding(PROBLEM, name, 'sends no pictures', 'check its cable and its source')]
    rate = (len(view.times) - 1) / max(1e-3, view.times[-1] - view.times[0])
    latency = float(np.median(view.latencies))
    seen = sorted(view.corners.keys() & file.floor_tags.keys())
    shifts = [
        float(
            np.hypot(
                *(view.projection.points(view.corners[tag], 0.0).mean(0) - file.floor_tags[tag])
            )
        )
        for tag in seen
    ]
    worst = max(shifts, default=np.inf)
    contrast = min((_contrast(view.picture, one) for one in view.corners.values()), default=0.0)
    found = f'{len(seen)} seen, at most {1e3 * worst:.0f} mm from their places'
    return [
        Finding(
            OK if rate >= _FEWEST_HZ else NOTE,
            name,
            f'{rate:.0f} pictures/s',
            '' if rate >= _FEWEST_HZ else 'more light or a shorter exposure gives more pictures',
        ),
        Finding(
            OK if latency <= _LATEST_S else NOTE,
            name,
            f'{1e3 * latency:.0f} ms from exposure to this program',
            '' if latency <= _LATEST_S else 'use a USB 3 port of this machine, without a hub',
        ),
        Finding(OK, 'floor tags', found)
        if worst <= MOST_SHIFT_M
        else Finding(
            PROBLEM,
            'floor tags',
            found if seen else 'none seen',
            'uncover them and put them back, or run setcmas camera with --calibrate floor',
        ),
        Finding(OK, 'light', f'tags differ by {contrast:.0f} grey levels or more')
        if contrast >= _LEAST_CONTRAST
        else Finding(
            NOTE,
            'light',
            f'tags differ by {contrast:.0f} grey levels',
            'more light, no glare, and a matt print',
        ),
    ]


def _of_arena(expected: list[Accuracy | None]) -> list[Finding]:
    known = [one for one in expected if one]
    share = len(known) / len(expected)
    findings = [
        Finding(OK, 'arena', 'seen as a whole')
        if share == 1
        else Finding(
            PROBLEM,
            'arena',
            f'{100 * share:.0f} % of it is seen',
            'hang the camera higher, add another one, or set a smaller arena in the lab file',
        )
    ]
    if not known:
        return findings
    pixels = min(one.pixels_per_tag for one in known)
    position, heading = max(one.position for one in known), max(one.heading for one in known)
    is_good = position <= _WORST_M and heading <= _WORST_RAD and pixels >= _FEWEST_PX
    text = f'{1e3 * position:.1f} mm and {np.degrees(heading):.1f} degrees at worst; '
    text += f'tags have {pixels:.0f} px or more'
    advice = '' if is_good else 'print larger tags, hang the camera lower, or add another one'
    return [*findings, Finding(OK if is_good else NOTE, 'accuracy', text, advice)]


def _contrast(picture: Picture, corners: Floats) -> float:
    """Return the difference in grey between the dark and the light parts of a tag."""
    low, high = corners.min(0).astype(int), corners.max(0).astype(int) + 1
    part = picture[low[1] : high[1], low[0] : high[0]]
    dark, light = np.percentile(part, (10, 90))
    return float(light - dark)


def _draw(view: _View, across: Floats, up: Floats, errors: Floats, path: Path) -> None:
    """Write a picture: what the camera sees, and the expected error over the arena in mm."""
    figure = Figure(figsize=(13, 4.8), layout='constrained')
    seen, place = figure.subplots(1, 2, width_ratios=(3, 2))
    _draw_picture(seen, view)
    mesh = place.contourf(across, up, errors, levels=12, cmap='viridis_r')
    figure.colorbar(mesh, ax=place, label='expected error of positions [mm]')
    x, y, _ = view.projection.camera.pose.position if view.projection.camera.pose else (0, 0, 0)
    place.plot(x, y, 'k^', label=view.projection.camera.name)
    place.set(aspect='equal', xlabel='x [m]', ylabel='y [m]', title='Arena')
    place.legend(loc='upper right')
    figure.savefig(path, dpi=110)


def _draw_picture(axes: Axes, view: _View) -> None:
    if view.picture is not None:
        axes.imshow(view.picture[..., ::-1] if view.picture.ndim == 3 else view.picture, 'gray')
    for tag, corners in view.corners.items():
        axes.fill(*corners.T, fill=False, color='tab:orange', linewidth=1.5)
        label = {'color': 'tab:orange', 'fontsize': 9, 'ha': 'center', 'va': 'bottom'}
        axes.text(corners[:, 0].mean(), corners[:, 1].min() - 4, str(tag), label)
    axes.set(
        title=f'{view.projection.camera.name}: {len(view.corners)} tags', xticks=[], yticks=[]
    )
