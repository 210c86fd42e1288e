"""Checks of cameras: rate, latency, light, floor tags, and what accuracy to expect where."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from setcmas_expe.doctor.findings import NOTE, OK, PROBLEM, Finding
from setcmas_expe.lab.lab import Lab
from setcmas_expe.mocap.camera_file import Accuracy, Camera, CameraFile, load_cameras
from setcmas_expe.mocap.camera_poses import MOST_SHIFT_M, Picture, TagDetector, floor_shifts
from setcmas_expe.mocap.picture_sources import pictures
from setcmas_simu.arrays import Floats

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
    """What a camera sent while it was watched."""

    camera: Camera
    times: list[float] = field(default_factory=list)
    latencies: list[float] = field(default_factory=list)
    corners: dict[int, Floats] = field(default_factory=dict)
    picture: Picture | None = None

    def watch(self) -> None:
        """Look at its pictures for a while."""
        end, detector = time.monotonic() + _WATCHED_S, TagDetector()
        for t, picture in pictures(self.camera.source, self.camera.lens.size):
            self.times.append(t)
            self.latencies.append(time.time() - t)
            self.corners |= detector.corners(picture)[0]
            self.picture = picture
            if time.monotonic() > end:
                break


def camera_findings(path: Path, lab: Lab) -> list[Finding]:
    """Return what is found about the cameras of a file, and write a picture for each beside it.

    Raises:
        SetcmasError: The file has a mistake, or a camera cannot be opened or is not calibrated.
    """
    file = load_cameras(path)
    across = np.linspace(lab.arena.xmin, lab.arena.xmax, _GRID)
    up = np.linspace(lab.arena.ymin, lab.arena.ymax, _GRID)
    expected = [_best(file, float(x), float(y)) for y in up for x in across]
    errors = np.array([1e3 * one.position if one else np.nan for one in expected])
    findings = _of_arena([one for one in expected if one], len(expected))
    for camera in file.cameras:
        view = _View(camera)
        view.watch()
        picture = path.with_name(f'{path.stem}_{camera.name}.png')
        _draw(view, across, up, errors.reshape(_GRID, _GRID), picture)
        findings += [*_of_camera(view, file), Finding(OK, camera.name, f'see {picture}')]
    return findings


def _best(file: CameraFile, x: float, y: float) -> Accuracy | None:
    found = filter(None, (one.accuracy(file.tags, x, y) for one in file.cameras))
    return min(found, key=lambda one: one.position, default=None)


def _of_camera(view: _View, file: CameraFile) -> list[Finding]:
    name = view.camera.name
    if view.picture is None:
        return [Finding(PROBLEM, name, 'sends no pictures', 'check its cable and its source')]
    rate = (len(view.times) - 1) / max(1e-3, view.times[-1] - view.times[0])
    latency = float(np.median(view.latencies))
    shifts = floor_shifts(view.camera, file.floor_tags, view.corners)
    worst = max(shifts.values(), default=np.inf)
    seen = f'{len(shifts)} seen, at most {1e3 * worst:.0f} mm from their places'
    back = 'uncover them and put them back, or run setcmas camera with --calibrate floor'
    contrast = min((_contrast(view.picture, one) for one in view.corners.values()), default=0.0)
    rates, ages = f'{rate:.0f} pictures/s', f'{1e3 * latency:.0f} ms from exposure to this program'
    greys = f'tags differ by {contrast:.0f} grey levels'
    port = 'use a USB 3 port of this machine, without a hub'
    return [
        _judged(rate >= _FEWEST_HZ, NOTE, name, rates, 'more light, or a shorter exposure'),
        _judged(latency <= _LATEST_S, NOTE, name, ages, port),
        _judged(worst <= MOST_SHIFT_M, PROBLEM, 'floor tags', seen if shifts else 'none', back),
        _judged(
            contrast >= _LEAST_CONTRAST, NOTE, 'light', greys, 'more light, no glare, a matt print'
        ),
    ]


def _of_arena(seen: list[Accuracy], nb_places: int) -> list[Finding]:
    share = f'{100 * len(seen) / nb_places:.0f} % of it is seen'
    advice = 'hang the camera higher, add another one, or set a smaller arena in the lab file'
    findings = [_judged(len(seen) == nb_places, PROBLEM, 'arena', share, advice)]
    if seen:
        pixels = min(one.pixels_per_tag for one in seen)
        position, heading = max(one.position for one in seen), max(one.heading for one in seen)
        is_good = position <= _WORST_M and heading <= _WORST_RAD and pixels >= _FEWEST_PX
        text = f'{1e3 * position:.1f} mm and {np.degrees(heading):.1f} degrees at worst; '
        text += f'tags have {pixels:.0f} px or more'
        advice = 'print larger tags, hang the camera lower, or add another one'
        findings.append(_judged(is_good, NOTE, 'accuracy', text, advice))
    return findings


def _judged(is_well: bool, level: str, what: str, found: str, advice: str) -> Finding:
    return Finding(OK, what, found) if is_well else Finding(level, what, found, advice)


def _contrast(picture: Picture, corners: Floats) -> float:
    """Return the difference in grey between the dark and the light parts of a tag."""
    low, high = corners.min(0).astype(int), corners.max(0).astype(int) + 1
    dark, light = np.percentile(picture[low[1] : high[1], low[0] : high[0]], (10, 90))
    return float(light - dark)


def _draw(view: _View, across: Floats, up: Floats, errors: Floats, path: Path) -> None:
    """Write a picture: what the camera sees, and the expected error over the arena in mm."""
    figure = Figure(figsize=(13, 4.8), layout='constrained')
    shown, place = figure.subplots(1, 2, width_ratios=(3, 2))
    if view.picture is not None:
        shown.imshow(view.picture[..., ::-1] if view.picture.ndim == 3 else view.picture, 'gray')
    for tag, corners in view.corners.items():
        shown.fill(*corners.T, fill=False, color='tab:orange', linewidth=1.5)
        x, y = corners[:, 0].mean(), corners[:, 1].min() - 4
        shown.text(x, y, str(tag), color='tab:orange', fontsize=9, ha='center', va='bottom')
    shown.set(title=f'{view.camera.name}: {len(view.corners)} tags', xticks=[], yticks=[])
    if np.isfinite(errors).any():
        mesh = place.contourf(across, up, errors, levels=12, cmap='viridis_r')
        figure.colorbar(mesh, ax=place, label='expected error of positions [mm]')
    place.plot(*view.camera.placed.position[:2], 'k^', label=view.camera.name)
    place.set(aspect='equal', xlabel='x [m]', ylabel='y [m]', title='Arena')
    place.legend(loc='upper right')
    figure.savefig(path, dpi=110)
