"""Triangle meshes of the scene's bodies; z up, the robot looks along x."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from setcmas_simu.arrays import Floats


@dataclass(frozen=True)
class Mesh:
    """Vertices in m, shape (V, 3), and triangles as indices of them, shape (F, 3)."""

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]


def merged(*meshes: Mesh) -> Mesh:
    """Return one mesh made of several."""
    offsets = np.cumsum([0, *[len(mesh.vertices) for mesh in meshes[:-1]]])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([m.faces + np.uint32(o) for m, o in zip(meshes, offsets, strict=True)]),
    )


def lathe(profile: list[tuple[float, float]], sides: int = 32) -> Mesh:
    """Return a body of revolution about z.

    Args:
        profile: (radius, z) in m, such that the outside is to the right of the way along it
            when radius points right and z up; edges of the profile stay sharp.
        sides: Number of facets.
    """
    angles = 2 * np.pi * np.arange(sides) / sides
    rings: list[Floats] = []
    faces: list[NDArray[np.int64]] = []
    for (r0, z0), (r1, z1) in itertools.pairwise(profile):
        base = 2 * sides * len(faces)
        for r, z in ((r0, z0), (r1, z1)):
            rings.append(np.stack([r * np.cos(angles), r * np.sin(angles), 0 * angles + z], 1))
        i = np.arange(sides)
        j = (i + 1) % sides
        lower, upper = base + i, base + sides + i
        lower_next, upper_next = base + j, base + sides + j
        triangles = [[lower, lower_next, upper_next], [lower, upper_next, upper]]
        faces.append(np.concatenate([np.stack(t, 1) for t in triangles]))
    return Mesh(np.concatenate(rings).astype(np.float32), np.concatenate(faces).astype(np.uint32))


def cylinder(radius: float, bottom: float, top: float, sides: int = 32) -> Mesh:
    """Return a closed upright cylinder; radius and heights in m."""
    return lathe([(0, bottom), (radius, bottom), (radius, top), (0, top)], sides)


def prism(outline: list[tuple[float, float]], bottom: float, top: float) -> Mesh:
    """Return a convex outline (x, y in m, counter-clockwise) with a height."""
    n = len(outline)
    xy = np.array(outline)
    low, high = (np.column_stack([xy, np.full(n, z)]) for z in (bottom, top))
    fan = np.array([[0, i, i + 1] for i in range(1, n - 1)])
    vertices, faces = [high, low], [fan, fan[:, ::-1] + n]
    for i in range(n):  # walls with vertices of their own, so that edges are sharp
        j, base = (i + 1) % n, 2 * n + 4 * i
        vertices.append(np.array([low[i], low[j], high[j], high[i]]))
        faces.append(np.array([[0, 1, 2], [0, 2, 3]]) + base)
    return Mesh(
        np.concatenate(vertices).astype(np.float32), np.concatenate(faces).astype(np.uint32)
    )


def box(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Mesh:
    """Return a box between two coordinates in each direction, in m."""
    return prism([(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])], *z)


def ring(inner: float, outer: float, height: float) -> Mesh:
    """Return a flat ring, seen from above, at a height; all in m."""
    return lathe([(outer, height), (inner, height)], sides=48)


def sphere(radius: float, sides: int = 16) -> Mesh:
    """Return a sphere, with smooth edges, of as many facets around as given."""
    polar = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sides // 2 + 1)
    azimuth = 2 * np.pi * np.arange(sides) / sides
    r, z = radius * np.cos(polar), radius * np.sin(polar)
    x, y = np.outer(r, np.cos(azimuth)), np.outer(r, np.sin(azimuth))
    vertices = np.stack([x, y, np.repeat(z[:, None], sides, 1)], -1).reshape(-1, 3)
    i, k = np.meshgrid(np.arange(sides // 2), np.arange(sides), indexing='ij')
    a, b = i * sides + k, i * sides + (k + 1) % sides
    faces = np.concatenate(
        [np.stack([a, b, b + sides], -1), np.stack([a, b + sides, a + sides], -1)]
    )
    return Mesh(vertices.astype(np.float32), faces.reshape(-1, 3).astype(np.uint32))


def turned_to_y(mesh: Mesh) -> Mesh:
    """Return a mesh whose z axis lies along y, such as the axle of a wheel."""
    x, y, z = mesh.vertices.T
    return Mesh(np.column_stack([x, z, -y]), mesh.faces)


def turned_to_x(mesh: Mesh) -> Mesh:
    """Return a mesh whose z axis lies along x."""
    x, y, z = mesh.vertices.T
    return Mesh(np.column_stack([z, y, -x]), mesh.faces)


def moved(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """Return a mesh moved by some m."""
    return Mesh(mesh.vertices + np.array([x, y, z], np.float32), mesh.faces)
