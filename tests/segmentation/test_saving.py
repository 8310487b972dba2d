"""`seg.save`, `Segmentation.load`, and how a notebook shows a segmentation."""

from __future__ import annotations

import json
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import geohue
from geohue import GeohueError, Scene, Segmentation
from geohue.read import read_color
from geohue.read.labels import read_segments
from geohue.results.borders import border_picture, vote_map
from geohue.results.picture import overlay, paint
from geohue.segmentation.words import weight_from, weight_in_words


@pytest.fixture(scope="module")
def stripes() -> Scene:
    """Three boxes in a row, with depth."""
    rgb = np.repeat(np.array([[200, 60, 50], [60, 160, 70], [70, 80, 190]], np.uint8), 20, axis=0)[
        None
    ]
    depth = np.repeat([1.0, 1.5, 2.0], 20)[None].repeat(40, 0)
    noise = np.random.default_rng(0).integers(0, 9, (40, 60, 3)).astype(np.uint8)
    return Scene.from_rgbd(rgb.repeat(40, 0) + noise, depth)


@pytest.fixture(scope="module")
def merged(stripes: Scene) -> Segmentation:
    return geohue.segment(stripes, preset="fast")


@pytest.fixture(scope="module")
def voted(stripes: Scene) -> Segmentation:
    return geohue.segment(stripes, preset="paper", weight="consensus")


def assert_same(one: Segmentation, other: Segmentation) -> None:
    for entry in fields(Segmentation):
        apart = ("scene", "levels", "timings", "border_votes", "shares")
        if not entry.init or entry.name in apart:
            continue
        np.testing.assert_equal(getattr(other, entry.name), getattr(one, entry.name), entry.name)
    assert other.labels.dtype == np.int32
    np.testing.assert_allclose(other.border_votes, one.border_votes, atol=1e-4)
    assert other.timings == pytest.approx(one.timings, abs=1e-4)


def test_what_is_saved_is_loaded(merged: Segmentation, tmp_path: Path) -> None:
    files = merged.save(tmp_path / "out", ["coco"])
    assert files[-1] == tmp_path / "out" / "result.json"
    assert sorted(files) == sorted((tmp_path / "out").iterdir())
    again = Segmentation.load(tmp_path / "out")
    assert_same(merged, again)
    assert again.levels is not None
    assert merged.levels is not None
    np.testing.assert_array_equal(again.levels.at("fine"), merged.levels.at("fine"))
    assert again.summary() == json.loads(json.dumps(merged.summary()))
    with pytest.raises(GeohueError, match="save needs the scene"):
        again.save(tmp_path / "other")


@pytest.mark.parametrize("weight", [0.0, 0.5, math.inf, math.nan])
def test_every_weight_is_loaded(merged: Segmentation, tmp_path: Path, weight: float) -> None:
    given = replace(merged, weight=weight, merged=False, levels=None)
    given.save(tmp_path / "out", lean=True)
    text = (tmp_path / "out" / "result.json").read_text()
    assert "NaN" not in text
    assert "Infinity" not in text
    again = Segmentation.load(tmp_path / "out")
    assert_same(given, again)
    assert "nan" not in repr(again)
    assert "inf" not in repr(again)
    number = None if not math.isfinite(weight) else weight
    np.testing.assert_equal(weight_from(number, weight_in_words(weight)), weight)


def test_a_lean_result_is_loaded_without_levels(merged: Segmentation, tmp_path: Path) -> None:
    names = [file.name for file in merged.save(tmp_path / "out", lean=True)]
    assert names == ["labels.png", "result.json"]
    again = Segmentation.load(tmp_path / "out")
    assert again.levels is None
    assert again.in_words() == merged.in_words() == "3 segments, regions merged"


def test_a_cloud_is_saved_and_loaded(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    xyz = rng.normal(0, 0.2, (200, 3)) + np.repeat([[0, 0, 0], [3, 0, 0]], 100, axis=0)
    xyz[5] = np.nan
    seg = geohue.segment(Scene.from_cloud(xyz, np.zeros((200, 3))), 2, cues="geometry")
    seg.save(tmp_path / "out")
    assert_same(seg, Segmentation.load(tmp_path / "out"))
    shown = seg.overlay()
    np.testing.assert_array_equal(shown, read_color(tmp_path / "out" / "overlay.png"))
    again = Segmentation.load(tmp_path / "out")
    assert again._repr_png_() is None
    assert "<img" not in again._repr_html_()
    with pytest.raises(GeohueError, match=r"overlay.png in its folder"):
        again.overlay()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda out: (out / "result.json").unlink(), "result.json: no such file"),
        (lambda out: (out / "labels.png").unlink(), "neither labels.png nor labels.npy"),
        (lambda out: (out / "result.json").write_text("{"), "no whole JSON file"),
        (lambda out: (out / "result.json").write_text("[]"), "no summary of a segmentation"),
        (lambda out: _edit(out, k=9), "says 9 segments, but the labels have 3"),
        (lambda out: _edit(out, k="many"), "no summary of a segmentation"),
        (lambda out: _edit(out, weight_curve=[3]), "no summary of a segmentation"),
        (lambda out: (out / "levels.npz").write_bytes(b"PK"), "levels.npz"),
    ],
)
def test_damage_is_named(merged: Segmentation, tmp_path: Path, change: Any, says: str) -> None:
    out = tmp_path / "out"
    merged.save(out)
    change(out)
    with pytest.raises(GeohueError, match=says):
        Segmentation.load(out)


def _edit(out: Path, **values: Any) -> None:
    content = json.loads((out / "result.json").read_text())
    (out / "result.json").write_text(json.dumps(content | values))


def test_a_folder_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="is no folder"):
        Segmentation.load(tmp_path / "nowhere")


def test_repr_is_one_short_line(merged: Segmentation) -> None:
    assert repr(merged).startswith(
        "<Segmentation: 3 segments, regions merged; 100% of 40 x 60 pixels labelled, "
    )
    assert len(repr(merged)) < 100


def test_pictures_for_notebooks(merged: Segmentation, stripes: Scene) -> None:
    np.testing.assert_array_equal(merged.overlay(), overlay(stripes.colors, merged.labels))
    white = np.full_like(stripes.colors, 255)
    np.testing.assert_array_equal(merged.overlay(white), overlay(white, merged.labels))
    np.testing.assert_array_equal(replace(merged, scene=None).overlay(), paint(merged.labels))
    with pytest.raises(GeohueError, match=r"shape \(3, 3\), the labels \(40, 60\)"):
        merged.overlay(np.zeros((3, 3, 3), np.uint8))
    png = merged._repr_png_()
    assert png is not None
    assert png.startswith(b"\x89PNG")
    page = replace(merged, warnings=("a < b",))._repr_html_()
    assert page.count("<img") == 1
    assert "3 segments, regions merged" in page
    assert "a &lt; b" in page


def test_large_pictures_are_made_small() -> None:
    import cv2

    labels = np.zeros((200, 2000), np.int32)
    seg = Segmentation(labels, 1, 0.0, None, [], "nncsc", "paper", "color", 0, {})
    png = seg._repr_png_()
    assert png is not None
    shown = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    assert shown is not None
    assert shown.shape == (64, 640, 3)


def test_votes_along_the_borders_are_drawn(
    voted: Segmentation, stripes: Scene, tmp_path: Path
) -> None:
    """In place of a curve of weights, of which none was searched."""
    pairs = {(one, other) for one, other, _ in voted.border_votes}
    across: NDArray[np.bool_] = voted.labels[:, 1:] != voted.labels[:, :-1]
    touching = {
        (min(a, b), max(a, b))
        for a, b in zip(
            voted.labels[:, :-1][across].tolist(), voted.labels[:, 1:][across].tolist(), strict=True
        )
    }
    assert voted.k >= 3
    assert pairs >= touching
    assert all(0.3 < share <= 1 for _, _, share in voted.border_votes)
    names = {file.name for file in voted.save(tmp_path / "out")}
    assert "borders.png" in names
    assert not names & {"weight_curve.png", "levels.npz"}
    drawn = border_picture(stripes, voted)
    assert drawn is not None
    np.testing.assert_array_equal(drawn, read_color(tmp_path / "out" / "borders.png"))
    assert [[a, b, round(s, 4)] for a, b, s in voted.border_votes] == json.loads(
        (tmp_path / "out" / "result.json").read_text()
    )["border_votes"]


def test_a_border_is_as_strong_as_its_votes() -> None:
    labels = np.array([[2, 2, 0, 1, -1]], np.int32)
    found = vote_map(labels, [(0, 1, 0.5), (0, 2, 0.875)])
    assert found.tolist() == [[0, 0.875, 0.5, 0, 0]]
    # A border that no vote is known for counts as the least certain one.
    assert vote_map(np.array([[1, 2]], np.int32), [(0, 1, 0.5), (0, 2, 0.875)]).tolist() == [
        [0.5, 0]
    ]


def test_one_numbering_whatever_the_file(merged: Segmentation, tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="needs geohue[clouds]")
    merged.save(tmp_path / "out", ["las", "pcd", "coco"])
    told = json.loads((tmp_path / "out" / "result.json").read_text())["numbering"]
    assert set(told) == {
        *("labels.png", "segmented.ply", "segmented.las", "segmented.pcd", "coco.json")
    }
    for name, how in told.items():
        if name == "coco.json":
            ids = [
                a["id"] for a in json.loads((tmp_path / "out" / name).read_text())["annotations"]
            ]
            assert ids == list(range(how["first"], how["first"] + merged.k))
            continue
        labels = read_segments(tmp_path / "out" / name)
        np.testing.assert_array_equal(labels.ravel(), merged.labels.ravel())
        assert how == (
            {"none": 0, "first": 1}
            if name == "labels.png"
            else {"field": how["field"], "none": -1, "first": 0}
        )
