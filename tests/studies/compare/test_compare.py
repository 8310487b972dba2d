"""A comparison: which cells there are, and that none takes the others down."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Scene
from geohue.features import CUES
from geohue.segmentation.driver import segment
from geohue.studies.compare import Cell, Comparison, Result, compare, plan_cells
from geohue.studies.compare.cells import all_rows
from geohue.studies.compare.run import Shared, choose_count, run_cell

Boxes = tuple[Scene, NDArray[np.int32]]


class TestPlan:
    def test_has_every_cell_of_figure_9(self) -> None:
        cells = plan_cells()
        assert len(cells) == len(all_rows()) * len(CUES)
        assert {"best", "nncsc", "kmeans", "meanshift", "felzenszwalb", "edison"} <= {
            cell.method for cell in cells
        }

    def test_keeps_the_order_given_and_drops_repetitions(self) -> None:
        cells = plan_cells(["edison", "nncsc", "edison"], ["geometry", "color"])
        assert [cell.name for cell in cells] == [
            "edison-geometry",
            "edison-color",
            "nncsc-geometry",
            "nncsc-color",
        ]

    @pytest.mark.parametrize(
        ("methods", "cues", "message"),
        [
            (["magic"], ["color"], "methods 'magic'"),
            (["nncsc"], ["depth"], "cues 'depth'"),
            ([], ["color"], "no methods"),
            (["nncsc"], [], "no cues"),
        ],
    )
    def test_unknown_names(self, methods: list[str], cues: list[str], message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            plan_cells(methods, cues)


class TestCompare:
    def test_a_failure_is_a_cell_and_no_more(self, faulty: Comparison) -> None:
        states = {result.cell.name: result.status for result in faulty.results}
        assert states == {
            "nncsc-fusion": "done",
            "nncsc-color": "done",
            "kmeans-fusion": "failed",
            "kmeans-color": "failed",
            "meanshift-fusion": "failed",
            "meanshift-color": "failed",
            "felzenszwalb-fusion": "failed",
            "felzenszwalb-color": "failed",
            "edison-fusion": "undefined",
            "edison-color": "done",
        }
        assert faulty.at("kmeans", "color").reason == "RuntimeError: <b>no & luck</b>"
        assert faulty.at("meanshift", "color").reason.startswith("the process died (signal 9")
        assert faulty.at("felzenszwalb", "fusion").reason == "not done after 12 s"
        assert "not defined for cues 'fusion'" in faulty.at("edison", "fusion").reason

    def test_labels_are_those_of_segment(self, faulty: Comparison, three_boxes: Boxes) -> None:
        scene, _ = three_boxes
        result, alone = faulty.at("nncsc", "fusion"), segment(scene, 3, preset="paper")
        assert result.labels is not None
        np.testing.assert_array_equal(result.labels, alone.labels)
        assert (result.k, result.weight, result.quality) == (3, alone.weight, alone.quality)
        assert result.seconds is not None
        assert 0 < result.seconds < 60

    def test_systems_with_their_own_pruning_keep_to_it(self) -> None:
        rng = np.random.default_rng(0)
        rgb = np.full((140, 160, 3), 90, np.uint8)
        rgb[60:66, 70:76] = (220, 40, 40)  # 36 pixels: above EDISON's 20, below 0.2 %
        scene = Scene.from_rgbd(rgb, 1 + rng.random((140, 160)))
        assert segment(scene, 2, cues="color", method="kmeans").k == 1
        assert segment(scene, 2, cues="color", method="edison").k == 2
        task = Shared(scene, None, 2, "paper", 0)
        assert run_cell(task, Cell("edison", "color")).k == 2

    def test_scores_against_the_truth(self, faulty: Comparison) -> None:
        scores = faulty.at("nncsc", "fusion").scores
        assert scores["rand"] > 0.99
        assert scores["voi_bits"] < 0.1
        assert faulty.at("nncsc", "color").scores["rand"] < 0.95
        assert faulty.at("kmeans", "color").scores == {}

    def test_summary_is_json(self, faulty: Comparison) -> None:
        content = json.loads(json.dumps(faulty.summary(), allow_nan=False))
        assert (content["k"], content["k_chosen"], len(content["cells"])) == (3, False, 10)
        assert content["cells"][0]["regions"] == 3
        assert content["cells"][2]["regions"] is None

    def test_k_is_chosen_once_for_all(self, three_boxes: Boxes) -> None:
        scene, _ = three_boxes
        done = compare(scene, ["kmeans"], ["color", "geometry"], processes=1)
        assert done.k_chosen
        assert done.k == choose_count(scene) == segment(scene, preset="paper").k
        assert {result.k for result in done.results} == {done.k}

    @pytest.mark.parametrize("preset", ["best", "fast"])
    @pytest.mark.parametrize("chosen", [True, False])
    def test_presets_that_merge_are_rows(
        self, preset: str, chosen: bool, three_boxes: Boxes
    ) -> None:
        scene, _ = three_boxes
        # K as another method is told it, and where it was not given the preset finds its own.
        result = run_cell(Shared(scene, None, 2, "paper", 3, chosen), Cell(preset, "fusion"))
        alone = segment(scene, "auto" if chosen else 2, preset=preset, seed=3)
        np.testing.assert_array_equal(result.labels, alone.labels)
        assert result.k == (3 if chosen else 2)
        assert result.weight is None

    def test_the_row_best_beside_the_others(self, three_boxes: Boxes) -> None:
        scene, truth = three_boxes
        done = compare(scene, ["best", "kmeans"], ["fusion"], truth=truth + 1, processes=1)
        assert done.at("best", "fusion").k == 3
        assert done.at("best", "fusion").scores["rand"] > 0.99
        assert done.methods == ("best", "kmeans")

    def test_an_image_alone_has_its_colour_cells(self) -> None:
        rgb = np.zeros((30, 40, 3), np.uint8)
        rgb[:, 20:] = 200
        seen: list[tuple[int, int, str]] = []
        done = compare(
            Scene.from_image(rgb),
            ["nncsc"],
            ["fusion", "color"],
            processes=1,
            progress=lambda count, total, result: seen.append((count, total, result.status)),
        )
        assert [result.status for result in done.results] == ["failed", "done"]
        assert "depth is missing" in done.results[0].reason
        assert seen == [(1, 2, "failed"), (2, 2, "done")]

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"k": 0}, "k is 0"),
            ({"processes": 0}, "processes is 0"),
            ({"timeout": 0}, "timeout is 0"),
            ({"timeout": math.nan}, "timeout is nan"),
            ({"preset": "ultra"}, "paper, fast, best"),
            ({"truth": np.ones((3, 3), int)}, r"ground truth has shape \(3, 3\)"),
            ({"methods": ["edison"], "cues": ["fusion"], "k": 2}, "not defined for cues"),
        ],
    )
    def test_bad_arguments(
        self, options: dict[str, object], message: str, three_boxes: Boxes
    ) -> None:
        with pytest.raises(GeohueError, match=message):
            compare(three_boxes[0], **options)  # type: ignore[arg-type]


def test_a_weight_that_is_not_finite_is_none_in_tables() -> None:
    for weight in (math.inf, math.nan):
        result = Result(Cell("edison", "geometry"), "done", k=2, seconds=1.0, weight=weight)
        assert result.row()["weight"] is None
