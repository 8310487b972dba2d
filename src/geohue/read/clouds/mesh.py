"""Meshes (OBJ, glTF, GLB) as clouds: their vertices, or points sampled on their faces."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError, GeohueWarning
from geohue.read.clouds.cloud import CloudData, build_cloud
from geohue.read.extras import optional
from geohue.read.files import broken, check_file, reason

_DENSE = 50_000
"""Vertices from which on they stand for the surface by themselves."""
_SAMPLES = 200_000
_GREY = 128

_Part = tuple[NDArray[np.float64], NDArray[np.uint8] | None]


def read_mesh(path: str | Path) -> CloudData:
    """Read a mesh as a cloud.

    Parameters
    ----------
    path : path-like
        OBJ, glTF or GLB; needs ``geohue[meshes]``.

    Returns
    -------
    CloudData
        The vertices where they are many and have colours. Otherwise 200000 points spread evenly
        over the faces, with the colours of the vertices between them or of the texture.

    Raises
    ------
    GeohueError
        If the file is missing, damaged or empty, or trimesh is.

    Warns
    -----
    GeohueWarning
        If points were sampled, which the file does not have.
    """
    trimesh = optional("trimesh", "meshes", path)
    check_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            parts = _placed(trimesh.load_scene(str(path), process=False))
    except GeohueError:
        raise
    except Exception as error:  # whatever a damaged file makes the many loaders raise
        cause = f"cannot be read as a mesh ({reason(error)}); export it again"
        raise broken(path, cause) from error
    n_vertices = sum(len(part.vertices) for part in parts)
    if n_vertices == 0:
        raise broken(path, "has no vertices; export it again")
    solid = [part for part in parts if len(getattr(part, "faces", ()))]
    if not solid or (n_vertices >= _DENSE and not any(_textured(part) for part in solid)):
        return _joined([_vertices(part) for part in parts], path)
    found = _joined(_sampled(trimesh, solid, max(_SAMPLES, n_vertices)), path)
    note = f"{path}: a mesh of {n_vertices} vertices: {len(found.points)} points sampled on it"
    warnings.warn(note, GeohueWarning, stacklevel=3)
    return found


def _placed(scene: Any) -> list[Any]:
    """Return the parts of a scene, each in its place."""
    parts = []
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        part = scene.geometry[name].copy()
        part.apply_transform(pose)
        parts.append(part)
    return parts


def _textured(part: Any) -> bool:
    return part.visual.kind in ("texture", "face")


def _vertices(part: Any) -> _Part:
    """Return the vertices of a mesh or the points of a cloud."""
    points = np.asarray(part.vertices, np.float64)
    colors = part.colors if hasattr(part, "colors") else None
    if colors is None and part.visual.kind == "vertex":
        colors = part.visual.vertex_colors
    return points, None if colors is None or not len(colors) else _bytes(colors)


def _sampled(trimesh: Any, parts: list[Any], count: int) -> list[_Part]:
    """Spread points over the faces, as many on each part as it has area."""
    areas = np.array([float(part.area) for part in parts])
    if not areas.sum() > 0:
        return [_vertices(part) for part in parts]
    found = []
    for part, share in zip(parts, areas / areas.sum(), strict=True):
        n = round(count * share)
        if n == 0:
            continue
        points, faces = trimesh.sample.sample_surface(part, n, seed=0)[:2]
        corners = part.triangles[faces]
        weights = trimesh.triangles.points_to_barycentric(corners, points)
        found.append((np.asarray(points, np.float64), _colors_at(trimesh, part, faces, weights)))
    return found


def _colors_at(
    trimesh: Any, part: Any, faces: NDArray[np.int64], weights: NDArray[np.float64]
) -> NDArray[np.uint8] | None:
    """Return the colours of points within faces, by their barycentric weights."""
    kind = part.visual.kind
    if kind == "face":
        return _bytes(part.visual.face_colors)[faces]
    corners = part.faces[faces]
    if kind == "vertex":
        colors = np.asarray(part.visual.vertex_colors, np.float64)[corners, :3]
        return _bytes(np.rint((weights[..., None] * colors).sum(axis=1)))
    if kind != "texture":
        return None
    material = part.visual.material
    image = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if image is None or part.visual.uv is None:
        return np.tile(_bytes([material.main_color]), (len(faces), 1))
    uv = (weights[..., None] * np.asarray(part.visual.uv)[corners]).sum(axis=1)
    return _bytes(trimesh.visual.color.uv_to_color(uv, image))


def _bytes(colors: Any) -> NDArray[np.uint8]:
    """Return red, green and blue of rows of colours."""
    return np.asarray(colors)[:, :3].astype(np.uint8)


def _joined(parts: list[_Part], path: str | Path) -> CloudData:
    """Return all parts as one cloud; those without colours are grey where others have some."""
    points = np.concatenate([points for points, _ in parts])
    colors = None
    if any(color is not None for _, color in parts):
        grey = ((np.full(p.shape, _GREY, np.uint8) if c is None else c) for p, c in parts)
        colors = np.concatenate(list(grey))
    axes = {axis: points[:, i] for i, axis in enumerate("xyz")}
    return build_cloud(axes, (len(points),), path, colors)
