"""The picture of BENCHMARKS.md: VoI of the presets on scenes that nothing was fitted on.

    python -m benchmarks.figures [-o docs/images/figures.png]

Draws the table of docs/studies/default.md, which ``python -m benchmarks.defaults`` measured.
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import matplotlib as mpl
import numpy as np

STUDY = Path(__file__).parents[1] / "docs" / "studies" / "default.md"
COLORS = {"paper": "#9a9a9a", "fast": "#7fb2d9", "best": "#1f5f99"}

_ROW = r"\| ([\w ]+) \| (\w+) \| (\d+) \| ([\d.]+) ± ([\d.]+) \|"


def measured(text: str) -> dict[tuple[str, str], tuple[int, float, float]]:
    """Find frames, VoI and its standard error for each kind of scenes and preset."""
    return {
        (scenes, preset): (int(n), float(voi), float(error))
        for scenes, preset, n, voi, error in re.findall(_ROW, text)
    }


def draw(file: Path) -> None:
    """Draw a bar for each preset, in groups of one kind of scenes."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    found = measured(STUDY.read_text("utf-8"))
    kinds = list(dict.fromkeys(scenes for scenes, _ in found))
    figure, axes = plt.subplots(figsize=(8, 3), layout="constrained")
    for i, (preset, color) in enumerate(COLORS.items()):
        rows = [found[kind, preset] for kind in kinds]
        places = np.arange(len(kinds)) + 0.27 * (i - 1)
        bars = axes.bar(places, [r[1] for r in rows], 0.25, yerr=[r[2] for r in rows], color=color)
        axes.bar_label(bars, fmt="%.2f", fontsize=7, padding=2)
        bars.set_label(preset)
    axes.set_xticks(range(len(kinds)), [f"{k}\n(n = {found[k, 'best'][0]})" for k in kinds])
    axes.set_ylabel("VoI, bits (less is better)")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure.savefig(file, dpi=120)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images/figures.png"))
    draw(parser.parse_args().output)
