"""The curve Q(lambda) as a picture, as in the paper's Figs. 4-6."""

from __future__ import annotations

from pathlib import Path

from geohue.results.atomic import atomic_write
from geohue.segmentation.result import Segmentation


def draw_weight_curve(path: str | Path, seg: Segmentation) -> None:
    """Draw Q against the weight, with the weight that was used.

    Parameters
    ----------
    path : str or Path
        The PNG to write.
    seg : Segmentation
        With at least one weight in its curve.

    Raises
    ------
    GeohueError
        If the file cannot be written.
    """
    # The object interface, without pyplot: no display, no global state.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 3.6), dpi=120, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set(xlabel="weight of geometry against colour, λ", ylabel="quality Q")
    weights, values = zip(*seg.weight_curve, strict=True)
    axes.set_xscale("log", base=2)
    axes.plot(weights, values, "o-", color="#0072B2", markersize=4)
    axes.axvline(seg.weight, color="#D55E00", linestyle="--")
    axes.set_title(f"λ = {seg.weight:.3g} chosen of {len(weights)}, K = {seg.k}")
    axes.grid(alpha=0.3)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format="png")
