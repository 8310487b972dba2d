"""A segmentation and its weight in words, for people and for JSON, which has no infinity."""

from __future__ import annotations

import math

from geohue.settings import PAPER_METHOD

NO_WEIGHT = "none"
ALONE = {0.0: "colour alone", math.inf: "geometry alone"}
"""The weights that leave out one of the two."""

_CUES = {"color": "colour alone", "geometry": "geometry alone"}


def weight_in_words(weight: float) -> str:
    """Return what a weight of geometry against colour means.

    Examples
    --------
    >>> weight_in_words(math.inf), weight_in_words(math.nan), weight_in_words(0.5)
    ('geometry alone', 'none', 'geometry 0.5 times colour')
    """
    if math.isnan(weight):
        return NO_WEIGHT
    return ALONE.get(weight, f"geometry {weight:.3g} times colour")


def weight_from(number: float | None, words: str) -> float:
    """Return the weight that was written as a number, or as words where it is none.

    Examples
    --------
    >>> weight_from(None, "geometry alone"), weight_from(2.0, "")
    (inf, 2.0)
    """
    if number is not None:
        return float(number)
    return math.inf if words == ALONE[math.inf] else math.nan


def told(k: int, weight: float, method: str, cues: str, merged: bool = False) -> str:
    """Return in words how many segments were found, and what they go by.

    Examples
    --------
    >>> told(17, math.inf, "nncsc", "fusion", merged=True)
    '17 segments, regions merged'
    >>> told(1, math.inf, "nncsc", "geometry")
    '1 segment, by geometry alone'
    >>> told(40, math.nan, "edison", "color")
    '40 segments, by edison'
    >>> told(4, 2.0, "nncsc", "fusion")
    '4 segments, weight 2'
    """
    return f"{k} segment{'' if k == 1 else 's'}, {_way(weight, method, cues, merged)}"


def _way(weight: float, method: str, cues: str, merged: bool) -> str:
    if merged:
        alone = _CUES.get(cues)
        return "regions merged" + (f" by {alone}" if alone else "")
    if math.isnan(weight):
        return "no weight" if method == PAPER_METHOD else f"by {method}"
    return f"by {ALONE[weight]}" if weight in ALONE else f"weight {weight:.3g}"
