"""The plate: every cell in its place, and what it says where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Scene
from geohue.studies.compare import Comparison, Result, draw_plate
from geohue.studies.compare.plate import arrange, caption, plate_layout
from geohue.studies.compare.views import cell_views, input_views, reference_of

Boxes = tuple[Scene, NDArray[np.int32]]
SIZE = 180


def test_cells_do_not_overlap_and_lie_inside(faulty: Comparison) -> None:
    layout = plate_layout(faulty, 3, 180, 120)
    assert (layout.rows, layout.columns) == (6, 3)
    width, height = layout.size
    taken = np.zeros((height, width), int)
    for row in range(layout.rows):
        for column in range(layout.columns):
            x, y = layout.corner(row, column)
            taken[y : y + layout.height + layout.caption // 2, x : x + layout.width] += 1
    assert taken.max() == 1
    assert taken.sum() == 18 * 180 * (120 + layout.caption // 2)
    assert not taken[:, : layout.side].any()  # the names of the methods


def test_every_picture_is_where_the_layout_says(faulty: Comparison, three_boxes: Boxes) -> None:
    scene, truth = three_boxes
    inputs = input_views(scene, truth + 1, reference_of(faulty))
    assert list(inputs) == ["image", "depth", "ground truth"]
    cells = cell_views(scene, faulty)
    assert list(cells) == ["nncsc-fusion", "nncsc-color", "edison-color"]
    plain = {
        name: np.full((60, 90, 3), 10 + 20 * i, np.uint8)
        for i, name in enumerate([*inputs, *cells])
    }
    shown_inputs = {name: plain[name] for name in inputs}
    shown_cells = {name: plain[name] for name in cells}
    plate = arrange(shown_inputs, shown_cells, faulty, SIZE)
    layout = plate_layout(faulty, 3, 180, 120)
    assert plate.shape == (*layout.size[::-1], 3)
    places = {(0, column): name for column, name in enumerate(inputs)}
    places |= {(1, 0): "nncsc-fusion", (1, 1): "nncsc-color", (5, 1): "edison-color"}
    for place, name in places.items():
        x, y = layout.corner(*place)
        assert (plate[y : y + 120, x : x + 180] == plain[name][0, 0]).all(), name
        assert (plate[y + 121 : y + 120 + layout.caption // 2, x : x + 180] < 100).any(), name


def test_gaps_are_marked(faulty: Comparison, three_boxes: Boxes) -> None:
    plate = draw_plate(three_boxes[0], faulty, size=SIZE)
    layout = plate_layout(faulty, 2, 180, 120)
    for row, column, color in ((2, 0, (250, 222, 214)), (5, 0, (236, 236, 236))):
        x, y = layout.corner(row, column)
        box = plate[y : y + 120, x : x + 180]
        assert (box[-1, -1] == color).all()
        assert (box < 120).any()  # the words


def test_parts_have_the_colour_of_the_first_cell(faulty: Comparison, three_boxes: Boxes) -> None:
    scene, truth = three_boxes
    inputs = input_views(scene, truth + 1, reference_of(faulty))
    cells = cell_views(scene, faulty)
    for part in range(3):
        inside = np.zeros(truth.shape, bool)
        inside[10:50, 30 * part + 6 : 30 * part + 24] = True
        first, true = (
            image[inside].mean(axis=0) for image in (cells["nncsc-fusion"], inputs["ground truth"])
        )
        np.testing.assert_allclose(first, true, atol=2)


def test_clouds_and_missing_depth_have_pictures() -> None:
    from geohue.studies.compare import Cell

    rng = np.random.default_rng(0)
    cloud = Scene.from_cloud(rng.random((400, 3)), rng.random((400, 3)))
    labels = np.arange(400, dtype=np.int32) % 2
    result = Result(Cell("kmeans", "color"), "done", "", labels, 2, 0.1, 0.0, 0.3)
    for scene, names in (
        (cloud, ["image"]),
        (Scene.from_image(np.zeros((20, 20, 3), np.uint8)), ["image"]),
    ):
        assert list(input_views(scene)) == names
    plate = draw_plate(cloud, Comparison((result,), 2, False, "paper", 0), size=SIZE)
    assert plate.dtype == np.uint8


@pytest.mark.parametrize("k", [1, 2])
def test_captions(k: int) -> None:
    from geohue.studies.compare import Cell

    scores = {"rand": 0.5, "voi_bits": 2.0, "covering": 0.1}
    fused = Result(Cell("nncsc", "fusion"), "done", "", None, k, 1.23, 1.5, 0.25, scores)
    first, second = caption(fused)
    assert first == f"{k} region{'s' if k > 1 else ''}, 1.2 s"
    assert second == "weight 1.5, Q 0.250, VoI 2.00, RI 0.50"
