"""How good is the chosen number of segments? Tables from scored sweeps.

    python -m benchmarks.k_study NAME=SCORES [NAME=SCORES ...] [-o FILE.md]

SCORES are folders that `benchmarks.scores` wrote. The selectors choose at weight 1, as the driver
asks them to; the segmentations compared are those at weight 1, and those at the best weight of
each frame and K, so that what the choice of the weight spoils does not count.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from benchmarks.scores import UNITS, Scores, load_scores
from benchmarks.sweep import KS, WEIGHTS
from numpy.typing import NDArray

from geohue.settings.cut import SELECTORS

Floats = NDArray[np.float64]


def tables(frames: list[Scores], unit: str) -> dict[str, Floats]:
    """Return VoI (frames, KS) at weight 1 and at the best weight of each frame and K."""
    voi = np.array([frame.voi[UNITS.index(unit)] for frame in frames])
    return {"weight 1": voi[:, WEIGHTS.index(1.0)], "best weight": voi[:, 1:-1].min(axis=1)}


def choices(frames: list[Scores]) -> dict[str, NDArray[np.int64]]:
    """Return the K of every frame by each selector; 1 counts as 2, the least that was cut."""
    chosen = np.array([frame.chosen for frame in frames])
    return {name: np.maximum(chosen[:, i], KS[0]) for i, name in enumerate(SELECTORS)}


def report(name: str, frames: list[Scores]) -> Iterator[str]:
    """Write the tables of one set of frames."""
    picked = choices(frames)
    for unit in UNITS:
        yield f"### {name}, {len(frames)} frames, {unit} as regions"
        yield ""
        yield "| K | mean K | VoI, weight 1 | regret | within 5 % | VoI, best weight | regret |"
        yield "| --- | --: | --: | --: | --: | --: | --: |"
        both = tables(frames, unit)
        for title, rows in _rows(picked, both, len(frames)):
            yield _line(title, rows, both)
        yield ""
    yield f"### {name}: how often each K is chosen, and is the best (components, weight 1)"
    yield ""
    yield "| | " + " | ".join(str(k) for k in KS) + " |"
    yield "| --- |" + " --: |" * len(KS)
    best = np.array(KS)[tables(frames, "components")["weight 1"].argmin(axis=1)]
    for title, values in {"best": best, **picked}.items():
        yield f"| {title} | " + " | ".join(str(int((values == k).sum())) for k in KS) + " |"
    yield ""


def _rows(
    picked: dict[str, NDArray[np.int64]], both: dict[str, Floats], count: int
) -> Iterator[tuple[str, dict[str, NDArray[np.int64]]]]:
    """Yield a title and, for each table, the column of KS that each frame takes."""
    yield "best of each frame", {name: voi.argmin(axis=1) for name, voi in both.items()}
    for selector, ks in picked.items():
        yield selector, dict.fromkeys(both, np.searchsorted(KS, ks))
    for k in KS:
        yield f"always {k}", dict.fromkeys(both, np.full(count, KS.index(k)))


def _line(title: str, rows: dict[str, NDArray[np.int64]], both: dict[str, Floats]) -> str:
    cells = [title, f"{np.array(KS)[rows['weight 1']].mean():.1f}"]
    for name, voi in both.items():
        best = voi.min(axis=1)
        found = voi[np.arange(len(voi)), rows[name]]
        cells += [f"{found.mean():.3f}", f"{(found - best).mean():.3f}"]
        if name == "weight 1":
            cells.append(f"{(found <= 1.05 * best + 1e-9).mean():.0%}")
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """Write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scores", nargs="+", metavar="NAME=SCORES")
    parser.add_argument("-o", "--out", type=Path)
    given = parser.parse_args()
    lines: list[str] = []
    for pair in given.scores:
        name, _, folder = pair.partition("=")
        lines += report(name, load_scores(Path(folder)))
    text = "\n".join(lines)
    print(text)
    if given.out is not None:
        given.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
