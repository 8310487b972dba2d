"""All measures of one pair at once."""

from __future__ import annotations

import json
import math
import time

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures import evaluate
from geohue.measures.boundary import boundary_displacement_error, boundary_precision_recall_f
from geohue.measures.partition import (
    adjusted_rand_index,
    rand_index,
    segmentation_covering,
    undersegmentation_error,
    variation_of_information,
)

Labels = NDArray[np.int64]

REGION_KEYS = [
    "voi_bits",
    "voi_nats",
    "over_bits",
    "under_bits",
    "rand",
    "adjusted_rand",
    "covering",
    "undersegmentation_error",
]
BOUNDARY_KEYS = ["boundary_precision", "boundary_recall", "boundary_f", "boundary_displacement"]
SIZE_KEYS = ["n_pred", "n_gt", "n_pixels"]


def frame(height: int, width: int, regions: int) -> tuple[Labels, Labels]:
    """Striped truth with an ignored band, and a wavy prediction with unlabelled pixels."""
    y, x = np.mgrid[:height, :width]
    gt = 1 + x * regions // width
    gt[:, ::40] = 0
    pred = (x + 9 * np.sin(y / 15)).astype(int) * 2 * regions // width
    pred[: height // 10, : width // 10] = -1
    return pred, gt


def test_equals_each_measure() -> None:
    pred, gt = frame(60, 80, 5)
    voi = variation_of_information(pred, gt)
    boundary = boundary_precision_recall_f(pred, gt, tolerance=2)
    assert evaluate(pred, gt, tolerance=2) == {
        "voi_bits": voi.total,
        "voi_nats": pytest.approx(variation_of_information(pred, gt, base=math.e).total),
        "over_bits": voi.over,
        "under_bits": voi.under,
        "rand": rand_index(pred, gt),
        "adjusted_rand": adjusted_rand_index(pred, gt),
        "covering": segmentation_covering(pred, gt),
        "undersegmentation_error": undersegmentation_error(pred, gt),
        "boundary_precision": boundary.precision,
        "boundary_recall": boundary.recall,
        "boundary_f": boundary.f,
        "boundary_displacement": boundary_displacement_error(pred, gt, tolerance=2),
        "n_pred": np.unique(pred[(gt != 0) & (pred != -1)]).size,
        "n_gt": 5,
        "n_pixels": np.count_nonzero(gt),
    }


def test_keys_and_json() -> None:
    scores = evaluate(*frame(20, 90, 3))
    assert list(scores) == REGION_KEYS + BOUNDARY_KEYS + SIZE_KEYS
    assert json.loads(json.dumps(scores, allow_nan=False)) == scores
    assert {type(scores[key]) for key in SIZE_KEYS} == {int}


def test_perfect() -> None:
    gt = frame(20, 90, 3)[1]
    scores = evaluate(gt + 5, gt)
    zero = [*REGION_KEYS[:4], "undersegmentation_error"]
    assert [scores[key] for key in zero] == [0] * 5
    assert [scores[key] for key in ("rand", "adjusted_rand", "covering")] == [1] * 3
    # The prediction also outlines the ignored lines, within the tolerance of the truth or of them.
    assert scores["boundary_f"] == 1


def test_crop() -> None:
    pred, gt = frame(50, 90, 4)
    assert evaluate(pred, gt, crop=(5, 45, 10, 80)) == evaluate(pred[5:45, 10:80], gt[5:45, 10:80])


def test_clouds_have_no_boundaries() -> None:
    pred, gt = frame(20, 90, 3)
    cloud, grid = evaluate(pred.ravel(), gt.ravel()), evaluate(pred, gt)
    assert cloud == {key: grid[key] for key in REGION_KEYS + SIZE_KEYS}


@pytest.mark.parametrize("crop", [(0, 51, 0, 90), (-1, 5, 0, 9), (5, 5, 0, 9), (0, 9, 8, 3)])
def test_bad_crop(crop: tuple[int, int, int, int]) -> None:
    pred, gt = frame(50, 90, 4)
    with pytest.raises(GeohueError, match=r"crop .* \(50, 90\).*top, bottom, left, right"):
        evaluate(pred, gt, crop=crop)


def test_bad_labels() -> None:
    pred, gt = frame(50, 90, 4)
    with pytest.raises(GeohueError, match=r"\(50, 89\).*\(50, 90\)"):
        evaluate(pred[:, 1:], gt)
    with pytest.raises(GeohueError, match="float32"):
        evaluate(pred.astype(np.float32), gt)
    with pytest.raises(GeohueError, match="crop"):
        evaluate(pred.ravel(), gt.ravel(), crop=(0, 1, 0, 1))
    with pytest.raises(GeohueError, match="no pixel is left"):
        evaluate(pred, gt * 0)


def test_a_frame_is_fast() -> None:
    # About 55 ms; the bound leaves room for slow machines, not for a sort or a loop over regions.
    pred, gt = frame(480, 640, 40)
    spent = []
    for _ in range(3):
        start = time.process_time()
        evaluate(pred, gt)
        spent.append(time.process_time() - start)
    assert min(spent) < 0.3
