"""Markers of control scripts, and the arena of an experiment."""

from __future__ import annotations

import time
from collections.abc import Callable

import viser

from setcmas_tools.view.model.marker_shapes import LABEL, LINES, SOLIDS
from setcmas_tools.view.model.marker_store import MarkerStore
from setcmas_tools.view.scene import meshes
from setcmas_tools.view.scene.batch import Batch
from setcmas_tools.view.scene.meshes import Mesh
from setcmas_tools.view.scene.tone import untoned

_PERIOD_S = 0.2
_MARKERS_PER_S = 10_000  # more of them are drawn anew less often


def _arrow() -> Mesh:
    """Return an arrow along x, 1 m long, whose head is 1 m wide."""
    profile = [(0.0, 0.0), (0.25, 0.0), (0.25, 0.75), (0.5, 0.75), (0.0, 1.0)]
    return meshes.turned_to_x(meshes.lathe(profile, 16))


_FORMS: dict[str, Callable[[], Mesh]] = {
    'arrow': _arrow,
    'cube': lambda: meshes.box((-0.5, 0.5), (-0.5, 0.5), (-0.5, 0.5)),
    'sphere': lambda: meshes.sphere(0.5),
    'cylinder': lambda: meshes.cylinder(0.5, -0.5, 0.5),
}


class MarkerScene:
    """Draws a store of markers, a batch for each kind of body."""

    def __init__(self, scene: viser.SceneApi, root: str = '') -> None:
        """Prepare, in a frame; nothing is drawn yet."""
        self._scene, self._root = scene, root
        self._batches: dict[tuple[str, bool], Batch] = {}
        self._lines: list[viser.LineSegmentsHandle] = []
        self._labels: list[viser.LabelHandle] = []
        self._next: dict[str, float] = {}

    def show(self, store: MarkerStore, poses: dict[int, tuple[float, float, float]]) -> None:
        """Draw what has changed, and what moves along with a robot.

        Args:
            store: The markers.
            poses: x, y (m) and theta (rad) of the robots.
        """
        now = time.monotonic()
        for kind in SOLIDS:
            if store.moves(kind):
                store.changed.add(kind)
                self._next[kind] = now
        for kind in [k for k in store.changed if now >= self._next.get(k, 0.0)]:
            store.changed.discard(kind)
            self._next[kind] = now + max(_PERIOD_S, len(store) / _MARKERS_PER_S)
            if kind == LINES:
                self._show_lines(store)
            elif kind == LABEL:
                self._show_labels(store)
            else:
                self._show_solids(kind, store, poses)

    def _show_solids(
        self, kind: str, store: MarkerStore, poses: dict[int, tuple[float, float, float]]
    ) -> None:
        rows = store.solids(kind, poses)
        seen_through = rows[:, 13] < 0.999
        for translucent, part in ((False, rows[~seen_through]), (True, rows[seen_through])):
            if (kind, translucent) not in self._batches:
                if not len(part):
                    continue
                name = f'{self._root}/markers/{kind}{"_translucent" if translucent else ""}'
                self._batches[kind, translucent] = Batch(
                    self._scene, name, _FORMS[kind](), smooth=kind == 'sphere'
                )
            self._batches[kind, translucent].show(
                part[:, :3], part[:, 3:7], part[:, 7:10], part[:, 10:13],
                part[:, 13] if translucent else None,
            )  # fmt: skip

    def _show_lines(self, store: MarkerStore) -> None:
        for line in self._lines:
            line.remove()
        self._lines = [
            self._scene.add_line_segments(
                f'{self._root}/markers/lines/{thickness:g}',
                rows[:, :6].reshape(-1, 2, 3),
                untoned(rows[:, 6:].reshape(-1, 2, 3)),
                thickness=thickness,
            )
            for thickness, rows in store.segments(LINES).items()
        ]

    def _show_labels(self, store: MarkerStore) -> None:
        for label in self._labels:
            label.remove()
        self._labels = [
            self._scene.add_label(
                f'{self._root}/markers/labels/{number}',
                found.text,
                position=tuple(found.rows[0, :3]),
                anchor='center-center',
                font_size_mode='scene',
                font_scene_height=max(float(found.rows[0, 9]), 0.05),
            )
            for number, (_, found) in enumerate(store.of_kind(LABEL))
        ]
