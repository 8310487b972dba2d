from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geohue import GeohueError, GeohueWarning, Scene
from geohue.read import read_cloud

trimesh = pytest.importorskip("trimesh", reason="needs geohue[meshes]")


def two_tiles() -> object:
    """A red square of 3 x 1 beside a blue one of 1 x 1."""
    vertices = [[0, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0], [3, 0, 0], [4, 0, 0], [4, 1, 0]]
    vertices += [[3, 1, 0]]
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    colors = [[255, 0, 0, 255]] * 4 + [[0, 0, 255, 255]] * 4
    return trimesh.Trimesh(vertices, faces, vertex_colors=colors, process=False)


@pytest.mark.parametrize("name", ["tiles.glb", "tiles.obj"])
def test_points_are_spread_over_the_faces(name: str, tmp_path: Path) -> None:
    two_tiles().export(tmp_path / name)  # type: ignore[attr-defined]
    with pytest.warns(GeohueWarning, match="a mesh of 8 vertices: 200000 points sampled on it"):
        cloud = read_cloud(tmp_path / name)
    assert cloud.colors is not None
    red = cloud.points[:, 0] < 3
    assert red.mean() == pytest.approx(0.75, abs=0.01)
    assert (cloud.colors[red] == [255, 0, 0]).all()
    assert (cloud.colors[~red] == [0, 0, 255]).all()
    with pytest.warns(GeohueWarning, match="sampled"):
        again = read_cloud(tmp_path / name)
    assert np.array_equal(cloud.points, again.points)
    assert "sampled" in Scene.from_cloud(tmp_path / name).warnings[0]


def test_a_texture(tmp_path: Path) -> None:
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd t.png\n")
    (tmp_path / "a.obj").write_text(
        "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    )
    from geohue.results import write_png

    image = np.zeros((64, 64, 3), np.uint8)
    image[:32] = (0, 255, 0)  # the upper half: v above a half
    write_png(tmp_path / "t.png", image)
    with pytest.warns(GeohueWarning, match="sampled"):
        cloud = read_cloud(tmp_path / "a.obj")
    assert cloud.colors is not None
    upper = cloud.points[:, 1] > 0.52
    assert (cloud.colors[upper] == [0, 255, 0]).all()
    assert (cloud.colors[cloud.points[:, 1] < 0.48] == 0).all()


def test_dense_vertices_stay_as_they_are(tmp_path: Path) -> None:
    x, y = np.meshgrid(np.arange(240.0), np.arange(240.0))
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    corner = (np.arange(239)[:, None] * 240 + np.arange(239)).ravel()
    faces = np.stack([corner, corner + 1, corner + 240], axis=1)
    colors = np.random.default_rng(0).integers(0, 256, (len(points), 4)).astype(np.uint8)
    colors[:, 3] = 255
    mesh = trimesh.Trimesh(points, faces, vertex_colors=colors, process=False)
    mesh.export(tmp_path / "dense.glb")
    cloud = read_cloud(tmp_path / "dense.glb")
    assert cloud.colors is not None
    assert np.array_equal(cloud.points, points)
    assert np.array_equal(cloud.colors, colors[:, :3])
    mesh.export(tmp_path / "dense.ply")  # read without trimesh: the vertices, faces left out
    assert np.array_equal(read_cloud(tmp_path / "dense.ply").points, points)


@pytest.mark.parametrize("name", ["a.obj", "a.glb", "a.gltf"])
@pytest.mark.parametrize("content", [b"no mesh", b"v 1 2\n", b"{}", b"glTF\x02\0\0\0"])
def test_what_is_no_mesh(name: str, content: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(GeohueError, match=rf"^{tmp_path / name}: "):
        read_cloud(tmp_path / name)
