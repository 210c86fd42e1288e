"""Batch of many bodies of one form: moving all of them takes one message."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats
from setcmas_tools.view.scene.meshes import Mesh
from setcmas_tools.view.scene.tone import untoned

_LEAST_CAPACITY = 8


class Batch:
    """Bodies of one form; their number may change."""

    def __init__(
        self, scene: viser.SceneApi, name: str, mesh: Mesh, smooth: bool = False, **look: Any
    ) -> None:
        """Prepare; nothing is drawn yet.

        Args:
            scene: Where to draw.
            name: In viser's tree of names.
            mesh: The form, in m.
            smooth: Whether edges between facets are smoothed.
            look: Further keywords of `add_batched_meshes_simple`.
        """
        self._scene = scene
        self._name = name
        self._mesh = mesh
        self._look: dict[str, Any] = {
            'flat_shading': not smooth,
            'lod': 'off',
            'cast_shadow': False,
            **look,
        }
        self._handle: viser.BatchedMeshHandle | None = None
        self._capacity = 0

    def show(
        self,
        positions: Floats,
        wxyzs: Floats,
        scales: Floats,
        colours: Floats,
        opacities: Floats | None = None,
    ) -> None:
        """Draw n bodies in place of the last ones.

        Args:
            positions: In m, shape (n, 3).
            wxyzs: Quaternions, shape (n, 4).
            scales: Along x, y, z of the body, shape (n, 3).
            colours: Red, green, blue from 0 to 1, shape (n, 3).
            opacities: From 0 to 1, shape (n,); either always or never given.
        """
        n = len(positions)
        if n > self._capacity or self._handle is None:
            if not n:
                return
            self._capacity = max(_LEAST_CAPACITY, 1 << (n - 1).bit_length())
            self._handle = None
        values: dict[str, Any] = {
            'batched_positions': self._padded(positions, 0.0),
            'batched_wxyzs': self._padded(wxyzs, 1.0),
            'batched_scales': self._padded(scales, 0.0),
            'batched_colors': np.round(255 * self._padded(untoned(colours), 0.0)).astype(np.uint8),
        }
        if opacities is not None:
            values['batched_opacities'] = self._padded(opacities[:, None], 0.0)[:, 0]
        if self._handle is None:
            self._handle = self._scene.add_batched_meshes_simple(
                self._name, self._mesh.vertices, self._mesh.faces, **values, **self._look
            )
            return
        for prop, value in values.items():  # viser sends what is different only
            setattr(self._handle, prop, value)

    def _padded(self, values: Floats, filling: float) -> NDArray[np.float32]:
        result = np.full((self._capacity, values.shape[1]), filling, np.float32)
        result[: len(values)] = values
        return result
