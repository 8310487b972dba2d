"""Messages of the library in the words of the command line: options in place of arguments."""

from __future__ import annotations

import re

_OPTIONS = {
    "depth_scale": "--depth-scale",
    "disparity_scale": "--disparity-scale",
    "min_depth": "--min-depth",
    "max_depth": "--max-depth",
    "least": "--least",
    "confidence": "--confidence",
    "mask": "--mask",
    "intrinsics": "--intrinsics",
    "disparity": "--disparity",
    "rig": "--calib",
    "pattern": "--pattern",
    "k": "-k",
    "weight": "--lambda",
    "cues": "--cues",
    "preset": "--preset",
    "detail": "--detail",
    "method": "--method",
    "seed": "--seed",
    "resume": "--resume",
}
_GIVEN = re.compile(
    rf"(?<![\w./-])({'|'.join(_OPTIONS)})=(\"[^\"]*\"|'[^']*'|\.\.\.|[\w./+-]*[\w/+-])"
)
_NAMED = re.compile(rf"(?<![\w./-])({'|'.join(n for n in _OPTIONS if '_' in n)})(?![\w./=-])")


def as_options(text: str) -> str:
    """Return a message with the arguments it names as options.

    Examples
    --------
    >>> as_options('go by cues="geometry", or give depth_scale=0.001 (not a depth_scale of 1)')
    'go by --cues geometry, or give --depth-scale 0.001 (not a --depth-scale of 1)'
    >>> as_options("give rig=... or resume=True; k=2 is fine; my/depth_scale.txt is no file")
    'give --calib or --resume; -k 2 is fine; my/depth_scale.txt is no file'
    """
    return _NAMED.sub(lambda found: _OPTIONS[found[1]], _GIVEN.sub(_option, text))


def _option(found: re.Match[str]) -> str:
    value = found[2].strip("\"'")
    option = _OPTIONS[found[1]]
    return option if value in ("...", "True") else f"{option} {value}"
