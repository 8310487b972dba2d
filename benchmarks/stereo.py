"""Measure stereo pairs: matching, warping, and segmentation with one view, two views and fill.

    python benchmarks/stereo.py [--seeds 2] [--k 4] [--scenes aloe,baby2] [--write docs/stereo.md]

Prints the tables of docs/stereo.md; with --write it puts them between the marks in that file. The
Middlebury pairs are looked for as the tests do (GEOHUE_DATA, or ../shared/data).
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

import geohue
from geohue.features import lab_of
from geohue.fill import fill_labels
from geohue.measures import evaluate
from geohue.read import read_color
from geohue.read.cameras.stereo_calibration import read_stereo_calibration
from geohue.read.images.disparity import read_disparity
from geohue.stereo import StereoPair, StereoRig, view_agreement

Labels = NDArray[np.int32]
Disparity = NDArray[np.float32]

# Full-size dmin of the third-size scenes, where it is known (SOURCE.txt of the data).
_DMIN = {"Aloe": 270, "Baby1": 300, "Bowling1": 290, "Cloth1": 290, "Flowerpots": 251}
_JUMP = 1.5  # px at a width of 430: a step of disparity that is an edge
_BEGIN, _END = "<!-- table -->", "<!-- end of table -->"
_NO_JUMPS = ("Cloth1 1/3",)  # one sheet: there is no edge to find
_CLAIM_KS = (3, 4, 5, 6)
_STAGES = ("one view", "one + fill", "two views", "two + fill")


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A pair with its ground truth."""

    name: str
    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    truth: Disparity
    rig: StereoRig | None


def cases(data: Path) -> Iterator[Case]:
    """Yield every Middlebury pair there is."""
    third = data / "middlebury2006_third"
    for folder in sorted(path for path in third.iterdir() if path.is_dir()):
        rig = _dmin_rig(_DMIN[folder.name]) if folder.name in _DMIN else None
        yield _case(f"{folder.name} 1/3", folder, folder / "disp1.png", 1 / 3, rig)
    half = data / "middlebury_half"
    for name, truth in (("Aloe/Aloe", "Aloe/Aloe"), ("Baby/Baby1", "Baby/Baby")):
        rig = read_stereo_calibration(half / name / "dmin.txt")
        title = f"{name.split('/')[1]} 1/2"
        yield _case(title, half / name, half / truth / "disp1.png", 1 / 2, rig)
    samples = data / "opencv_samples"
    left, right = (read_color(samples / f"aloe{side}.jpg") for side in "LR")
    truth_full = read_disparity(samples / "aloeGT.png", 1).disparity
    yield Case("Aloe 1/1", left, right, truth_full, _dmin_rig(270))
    yield motorcycle()


def motorcycle() -> Case:
    """Return the Middlebury 2014 pair that scikit-image carries, with its calibration."""
    from skimage.data import stereo_motorcycle

    left, right, truth = stereo_motorcycle()
    f, cx, cy = 994.978, 311.193, 254.877
    camera = geohue.Intrinsics(f, f, cx, cy, left.shape[1], left.shape[0])
    other = geohue.Intrinsics(f, f, cx + 31.086, cy, left.shape[1], left.shape[0])
    known = np.where(np.isfinite(truth), truth, np.nan).astype(np.float32)
    return Case("Motorcycle 1/4", left, right, known, StereoRig(camera, other, 0.193001))


def _dmin_rig(dmin: float) -> StereoRig:
    camera = geohue.Intrinsics(3740.0, 3740.0, 0.0, 0.0, None, 1110)
    return StereoRig(camera, camera, 0.160, dmin, centre_known=False)


def _case(name: str, folder: Path, truth: Path, scale: float, rig: StereoRig | None) -> Case:
    left, right = (read_color(folder / f"view{n}.png") for n in (1, 5))
    return Case(name, left, right, read_disparity(truth, scale).disparity, rig)


# --- the figures ---------------------------------------------------------------------------------


def matching_row(case: Case, matched: StereoPair, true: StereoPair) -> list[str]:
    """Bad pixels and density of the matching, warping errors of both disparities."""
    known = np.isfinite(case.truth)
    both = known & np.isfinite(matched.disparity)
    error = np.abs(matched.disparity - case.truth)[both]
    ours, theirs = matched.warp(), true.warp()
    height, width = case.truth.shape
    return [
        f"{case.name} ({width} x {height})",
        f"{100 * (error > 1).mean():.1f}",
        f"{100 * (error > 2).mean():.1f}",
        f"{100 * both.sum() / known.sum():.1f}",
        f"{ours.error:.1f}",
        f"{theirs.error:.1f}",
        f"{100 * theirs.occluded.mean():.1f}",
    ]


def disparity_regions(truth: Disparity) -> Labels:
    """Return the smooth pieces of a disparity map from 1, 0 where it is unknown.

    Neighbours belong together unless their disparities differ by a jump.
    """
    jump = _JUMP * truth.shape[1] / 430
    index = np.arange(truth.size).reshape(truth.shape)
    pairs = []
    for a, b in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        with np.errstate(invalid="ignore"):
            joined = np.abs(truth[a] - truth[b]) <= jump
        pairs.append(np.stack([index[a][joined], index[b][joined]]))
    rows, columns = np.concatenate(pairs, axis=1)
    graph = sparse.coo_array((np.ones(rows.size), (rows, columns)), shape=(truth.size,) * 2)
    pieces = connected_components(graph, directed=False)[1].reshape(truth.shape)
    return np.where(np.isfinite(truth), pieces + 1, 0).astype(np.int32)


def stages(pair: StereoPair, k: int, seed: int) -> list[Labels]:
    """Return the labels of Fig. 11c, d and e, and between them c with fill: c, c+, d, e."""
    one, two = (
        geohue.segment(geohue.Scene.from_pair(pair, views), k=k, seed=seed, fill=False).labels
        for views in (1, 2)
    )
    return [one, filled(pair, one), two, filled(pair, two)]


def filled(pair: StereoPair, labels: Labels) -> Labels:
    """Return the labels after the Appendix, as `segment` does it last."""
    return fill_labels(labels, lab_of(pair.left))


def segmentation_rows(
    case: Case, matched: StereoPair, true: StereoPair, k: int, seeds: int
) -> tuple[list[str], list[str]]:
    """Return the rows of agreement and of boundaries, means over the seeds."""
    edges = disparity_regions(case.truth)
    agreement: list[list[float]] = []
    borders: list[list[float]] = []
    views: list[float] = []
    for seed in range(seeds):
        labels, reference = stages(matched, k, seed), stages(true, k, seed)
        targets = (reference[1], reference[1], reference[3], reference[3])
        scores = [evaluate(a, b, ignore=None) for a, b in zip(labels, targets, strict=True)]
        agreement.append([s["voi_bits"] for s in scores] + [s["rand"] for s in scores])
        whole = (labels[1], labels[3], reference[1], reference[3])
        borders.append([evaluate(found, edges, ignore=0)["boundary_f"] for found in whole])
        views.append(_both_views(matched, labels[2], k, seed))
    mean = np.mean(agreement, axis=0)
    first = [case.name, *(f"{value:.2f}" for value in mean), f"{100 * np.mean(views):.0f}"]
    return first, [case.name, *(f"{value:.2f}" for value in np.mean(borders, axis=0))]


def _both_views(pair: StereoPair, labels: Labels, k: int, seed: int) -> float:
    mirrored = geohue.segment(
        geohue.Scene.from_pair(pair.swapped()), k=k, seed=seed, fill=False
    ).labels
    return view_agreement(labels, mirrored[:, ::-1], pair.disparity).share or 0.0


def others(data: Path) -> list[list[str]]:
    """Match the pairs that have no ground truth."""
    oak, kitti = data / "stereodemo_oakd", data / "kitti_stereo_lidar" / "demo"
    files = [("KITTI", kitti / "left.png", kitti / "calib.txt")]
    files += [
        (f"OAK-D {path.stem.removesuffix('_left')}", path, oak / "stereodemo_calibration.json")
        for path in sorted(oak.glob("*_left.png"))
    ]
    rows = []
    for name, path, calibration in files:
        right = path.with_name(path.name.replace("left", "right"))
        rig = read_stereo_calibration(calibration)
        pair = StereoPair.prepare(read_color(path), read_color(right), rig)
        density = float(np.isfinite(pair.disparity).mean())
        rows.append([name, f"{100 * density:.0f}", f"{pair.warp().error:.1f}"])
    return rows


def claims(case: Case, pair: StereoPair, source: str, seeds: int) -> list[list[str]]:
    """Measure what Sec. VI-B says of the third-size aloe: leaf and vase, with one view and two.

    A pixel of the leaf is right if it has the label of most of the plant, one of the vase's dark
    side if it has the label of most of the vase's bright side.
    """
    near = np.nan_to_num(case.truth) > 27  # in front of the background, which ends at 25
    parts = {"leaf": (np.s_[45:180, 290:340], np.s_[190:260, 200:290]),
             "vase": (np.s_[285:345, 315:350], np.s_[285:345, 245:310])}  # fmt: skip
    rows = []
    for k in _CLAIM_KS:
        runs = [stages(pair, k, seed) for seed in range(seeds)]
        for name, (part, core) in parts.items():
            shares = [[_share(found, near, part, core) for found in run] for run in runs]
            spread = np.array(shares)
            ends = zip(spread.mean(axis=0), spread.std(axis=0), strict=True)
            cells = (f"{100 * mean:.0f} ± {100 * deviation:.0f}" for mean, deviation in ends)
            rows.append([f"{name}, K = {k}, {source} disparity", *cells])
    return rows


def _share(labels: Labels, near: NDArray[np.bool_], part: Any, core: Any) -> float:
    inner = labels[core][near[core] & (labels[core] >= 0)]
    if inner.size == 0:
        return 0.0
    own = np.bincount(inner).argmax()
    return float((labels[part][near[part]] == own).mean())


# --- the tables ----------------------------------------------------------------------------------


def table(head: list[str], rows: list[list[str]]) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def report(data: Path, k: int, seeds: int, wanted: set[str]) -> str:
    """Return all tables as Markdown."""
    matching, agreement, borders, said = [], [], [], []
    for case in cases(data):
        if wanted and not wanted & {case.name.lower(), case.name.split()[0].lower()}:
            continue
        print(case.name, file=sys.stderr, flush=True)
        matched = StereoPair.prepare(case.left, case.right, case.rig)
        true = StereoPair.prepare(case.left, case.right, case.rig, case.truth)
        matching.append(matching_row(case, matched, true))
        first, second = segmentation_rows(case, matched, true, k, seeds)
        agreement.append(first)
        borders.append(second)
        if case.name == "Aloe 1/3":
            said = claims(case, matched, "matched", 2 * seeds)
            said += claims(case, true, "true", 2 * seeds)
    for rows in (matching, agreement, borders):
        known = [row for row in rows if rows is not borders or row[0] not in _NO_JUMPS]
        means = np.mean([[float(cell) for cell in row[1:]] for row in known], axis=0)
        digits = 1 if rows is matching else 2
        rows.append(["**mean**", *(f"{value:.{digits}f}" for value in means)])
    head = (
        f"`python benchmarks/stereo.py --k {k} --seeds {seeds}` with geohue "
        f"{geohue.__version__}, OpenCV {cv2.__version__}, NumPy {np.__version__}, "
        f"Python {platform.python_version()}.\n"
    )
    parts = [
        head,
        "Matching:\n",
        table(["pair", "bad > 1 px, %", "bad > 2 px, %", "density, %", "warping error, matched",
               "warping error, true", "occluded, %"], matching),
        "\nAgreement of the segmentation from the matched disparity with that from the true one "
        "(filled, same number of views):\n",
        table(["pair", *(f"VoI, {s}" for s in _STAGES), *(f"Rand, {s}" for s in _STAGES),
               "both views agree, %"], agreement),
        "\nBoundary F against the edges of the true disparity (mean without Cloth1, which has "
        "none):\n",
        table(["pair", *(f"{n}, {source}" for source in ("matched", "true")
                         for n in ("one + fill", "two + fill"))], borders),
    ]  # fmt: skip
    if not wanted:
        head_others = ["pair", "density, %", "warping error, matched"]
        parts += ["\nPairs without ground truth:\n", table(head_others, others(data))]
    if said:
        parts += [
            "\nAloe, third size, share of the pixels with the right label, % (mean and deviation "
            f"over {2 * seeds} seeds):\n",
            table(["part", *_STAGES], said),
        ]
    return "\n".join(parts)


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description="Measure stereo matching and segmentation.")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--k", type=int, default=4)
    parser.add_argument("--scenes", default="")
    parser.add_argument("--write", type=Path)
    options = parser.parse_args()
    default = Path(__file__).parents[2] / "shared" / "data"
    data = Path(os.environ.get("GEOHUE_DATA", default))
    wanted = {name.strip().lower() for name in options.scenes.split(",") if name.strip()}
    text = report(data, options.k, options.seeds, wanted)
    print(text)
    if options.write is not None:
        page = options.write.read_text(encoding="utf-8")
        before, rest = page.split(_BEGIN, 1)
        after = rest.split(_END, 1)[1]
        new = f"{before}{_BEGIN}\n\n{text}\n\n{_END}{after}"
        options.write.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
