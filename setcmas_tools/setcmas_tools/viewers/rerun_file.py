"""A run as a file for Rerun: the scene and the curves, on one time line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.archetypes import PlotBackground

from setcmas_simu.arrays import Floats
from setcmas_simu.fleet.fleet import colour, plot_colour
from setcmas_simu.fleet.topics import robot_name
from setcmas_simu.robots.models import shape_of
from setcmas_tools.records.drawings import MARKER, Drawing, DrawnOverTime
from setcmas_tools.records.gaps import gaps
from setcmas_tools.replay.curves import FLEET, Curve, curves
from setcmas_tools.run.arena import arena_of, models_of, obstacles_of
from setcmas_tools.run.run import Run
from setcmas_tools.view.scene.meshes import Mesh
from setcmas_tools.view.scene.robot_mesh import coloured_body, dark_body, drawn_size

TIME_LINE = 't'
_EYE, _LEAST_WIDTH_M = np.array([-0.15, -0.7, 0.75]), 2.0
_DARK = (0.16, 0.18, 0.21)
_GREY = (0.5, 0.5, 0.5)
_LEAST = 1e-12
_PAPER, _WHITE = (0.86, 0.88, 0.9), (1.0, 1.0, 1.0)
_TRAIL_RADIUS_M = 0.02
_ARROW_M, _NUMBER_M = 0.25, 0.2
_TRAILS, _DRAWN = 'world/trails', 'world/drawn'


def write_rrd(run: Run, path: Path) -> None:
    """Write a run for Rerun; t = 0 is the first command.

    Raises:
        OSError: The file cannot be written.
    """
    recording = rr.RecordingStream('setcmas')
    content = recording.memory_recording()  # a full disk would go unnoticed in rerun's own thread
    found = curves(run)
    recording.send_blueprint(_blueprint(run, found))
    recording.send_recording_name(run.title)
    recording.log('world', rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    _send_world(recording, run)
    for robot, model in models_of(run).items():
        _send_robot(recording, run, robot, model)
    _send_drawings(recording, run)
    for curve in found:
        _send_curve(recording, curve)
    path.write_bytes(content.drain_as_bytes())


def _send_world(recording: rr.RecordingStream, run: Run) -> None:
    """Send the arena and the obstacles, which stay."""
    obstacles = obstacles_of(run)
    outlines = [np.array(one.corners) for one in obstacles.polygons]
    angles = np.linspace(0, 2 * np.pi, 33)
    for disc in obstacles.discs:
        around = disc.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        outlines.append(around + np.array([disc.x, disc.y]))
    if arena := arena_of(run):
        x0, x1, y0, y1 = arena
        outlines.append(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]))
    if outlines:
        strips = [np.vstack([one, one[:1]]) for one in outlines]
        drawn = rr.LineStrips3D([_on_ground(*one.T) for one in strips], colors=_GREY)
        recording.log('world/borders', drawn, static=True)


def _send_robot(recording: rr.RecordingStream, run: Run, robot: int, model: str) -> None:
    """Send the body of a robot, its poses and its trail."""
    track, name = run[robot], robot_name(robot)
    path = f'world/robots/{name}'
    shape = shape_of(model)
    for part, body, paint in (
        ('body', coloured_body(shape), colour(robot)),
        ('dark', dark_body(shape), _DARK),
    ):
        recording.log(f'{path}/{part}', _mesh(body, paint), static=True)
    heading = rr.Arrows3D(
        vectors=[_ARROW_M, 0, 0], origins=[0, 0, shape.height], colors=colour(robot)
    )
    recording.log(f'{path}/heading', heading, static=True)
    above = [0, 0, shape.height + _NUMBER_M]
    number = rr.Points3D([above], labels=str(robot), radii=0, colors=_WHITE)
    recording.log(f'{path}/number', number, static=True)
    positions = _on_ground(track.x, track.y)
    half = 0.5 * track.theta
    quaternions = np.column_stack([np.zeros((len(half), 2)), np.sin(half), np.cos(half)])
    scales = np.full_like(positions, drawn_size(run.tables.safety is not None))
    poses = rr.Transform3D.columns(translation=positions, quaternion=quaternions, scale=scales)
    recording.send_columns(path, [_times(track.t)], poses)
    driven = np.flatnonzero(~gaps(track))
    if len(driven):
        steps = np.stack([positions[driven], positions[driven + 1]], axis=1)
        trail = rr.LineStrips3D.columns(
            strips=list(steps),
            colors=[plot_colour(robot)] * len(steps),
            radii=[_TRAIL_RADIUS_M] * len(steps),
        )
        recording.send_columns(f'{_TRAILS}/{name}', [_times(track.t[driven + 1])], trail)


def _send_drawings(recording: rr.RecordingStream, run: Run) -> None:
    """Send what scripts drew: each name of a robot by itself, markers apart from trails."""
    drawn: dict[str, list[Drawing]] = {}
    for one in DrawnOverTime(run.drawings).shown:
        place = 'world/markers' if one.kind == MARKER else _DRAWN
        drawn.setdefault(f'{place}/{robot_name(one.robot)}/{one.name}', []).append(one)
    for path, drawings in drawn.items():
        spheres = [one.sphere for one in drawings]
        points = rr.Points3D.columns(
            positions=[(s.x, s.y, s.z) for s in spheres],
            radii=[0.5 * s.diameter for s in spheres],
            colors=np.clip([(*s.colour, s.alpha) for s in spheres], 0.0, 1.0),
        )
        recording.send_columns(path, [_times(np.array([one.t for one in drawings]))], points)


def _send_curve(recording: rr.RecordingStream, curve: Curve) -> None:
    for robot, values in curve.values.items():
        path = _path(curve) if robot == FLEET else f'{_path(curve)}/{robot_name(robot)}'
        paint = (0.3, 0.3, 0.3) if robot == FLEET else plot_colour(robot)
        name = 'fleet' if robot == FLEET else robot_name(robot)
        recording.log(path, rr.SeriesLines(colors=paint, names=name), static=True)
        known = np.isfinite(values)
        scalars = rr.Scalars.columns(scalars=values[known])
        recording.send_columns(path, [_times(curve.t[known])], scalars)


def _blueprint(run: Run, found: list[Curve]) -> rrb.Blueprint:
    """Return how Rerun shows the run: the scene beside the curves; trails keep what they had."""
    so_far = rrb.VisibleTimeRanges(
        [
            rrb.VisibleTimeRange(
                TIME_LINE,
                start=rrb.TimeRangeBoundary.infinite(),
                end=rrb.TimeRangeBoundary.cursor_relative(),
            )
        ]
    )
    kept = [f'{_TRAILS}/{robot_name(robot)}' for robot in run.robots]
    kept += {f'{_DRAWN}/{robot_name(one.robot)}/{one.name}' for one in run.drawings}
    scene = rrb.Spatial3DView(
        origin='world',
        name=run.title,
        background=_PAPER,
        eye_controls=_eye(run),
        overrides={path: [so_far] for path in kept},
    )
    views = [
        rrb.TimeSeriesView(
            origin=_path(curve),
            name=f'{curve.name} ({curve.unit})',
            background=PlotBackground(color=_PAPER),
        )
        for curve in found
    ]
    return rrb.Blueprint(
        rrb.Horizontal(scene, rrb.Vertical(*views), column_shares=[3, 2]),
        rrb.TimePanel(timeline=TIME_LINE, state='collapsed'),
        collapse_panels=True,
    )


def _eye(run: Run) -> rrb.EyeControls3D:
    """Return a place from where all is seen."""
    arena = arena_of(run) or (np.nan,) * 4
    places = np.array([[*run.table.x, *arena[:2]], [*run.table.y, *arena[2:]]])
    low, high = np.nanmin(places, axis=1), np.nanmax(places, axis=1)
    target = np.append(0.5 * (low + high), 0.0)
    eye = target + _EYE * (np.hypot(*(high - low)) + _LEAST_WIDTH_M)
    return rrb.EyeControls3D(position=eye, look_target=target, eye_up=[0, 0, 1])


def _path(curve: Curve) -> str:
    return f'curves/{curve.name.lower().replace(" ", "_")}'


def _mesh(body: Mesh, paint: tuple[float, float, float]) -> rr.Mesh3D:
    corners = body.vertices[body.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), _LEAST)
    return rr.Mesh3D(
        vertex_positions=corners.reshape(-1, 3),
        vertex_normals=np.repeat(normals, 3, axis=0),
        albedo_factor=(*paint, 1.0),
    )


def _on_ground(x: Floats, y: Floats) -> Floats:
    """Return points on the ground, shape (K, 3)."""
    return np.column_stack([x, y, np.zeros(len(x))])


def _times(t: Floats) -> rr.TimeColumn:
    return rr.TimeColumn(TIME_LINE, duration=np.round(1e9 * t).astype('timedelta64[ns]'))
