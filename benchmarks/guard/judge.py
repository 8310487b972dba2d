"""What two series of measurements, taken turn by turn, say of a change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median, quantiles
from typing import Literal

Verdict = Literal["slower", "faster", "same"]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two series side by side; the larger value is the worse.

    Attributes
    ----------
    base, head : float
        The medians.
    ratio, low, high : float
        Median and quartiles of head over base, pair by pair: what slows down the whole machine
        for a while hits both of a pair.
    verdict : {"slower", "faster", "same"}
        Slower: the ratio is above the tolerance, and three pairs of four are above 1, so that it
        is no noise. Faster: likewise below its inverse.
    """

    base: float
    head: float
    ratio: float
    low: float
    high: float
    verdict: Verdict


def compare(base: Sequence[float], head: Sequence[float], tolerance: float) -> Comparison:
    """Compare measurements of two revisions, the i-th of both taken one after the other.

    Parameters
    ----------
    base, head : sequence of float
        Positive values, equally many, at least 3.
    tolerance : float
        Ratio that is still well, at least 1.

    Examples
    --------
    >>> compare([1.0, 2.0, 1.0, 1.0], [1.5, 3.0, 1.5, 1.4], tolerance=1.25).verdict
    'slower'
    """
    if len(base) != len(head) or len(base) < 3:
        raise ValueError(f"{len(base)} and {len(head)} measurements: expected 3 or more pairs")
    ratios = [new / old for old, new in zip(base, head, strict=True)]
    low, ratio, high = quantiles(ratios, n=4, method="inclusive")
    verdict: Verdict = "same"
    if ratio > tolerance and low > 1:
        verdict = "slower"
    elif ratio < 1 / tolerance and high < 1:
        verdict = "faster"
    return Comparison(median(base), median(head), ratio, low, high, verdict)
