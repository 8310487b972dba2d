"""What a request asks for: the settings of a segmentation, checked."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from geohue.errors import GeohueError
from geohue.merge.levels import DETAILS
from geohue.settings import PAPER_METHOD, PRESETS
from geohue.settings.weight import WEIGHT_RULES

CUES = ("fusion", "color", "geometry")
RULES = ("auto", *WEIGHT_RULES)

_NUMBERS = re.compile(r"[-+.,;\s\deE]{1,200}")
_UNIT = re.compile(r"[\w.+/-]{1,30}")


@dataclass(frozen=True, slots=True)
class Wishes:
    """The settings of one segmentation, as `geohue.segment` and the readers take them.

    Attributes
    ----------
    preset, k, weight, detail, cues, method, seed
        As in `geohue.segment`.
    depth_scale, disparity_scale : str
        As of the command line; empty for the default.
    intrinsics, calib : str
        Numbers alone, "fx,fy,cx,cy" and "f,baseline[,doffs[,cx,cy]]"; empty for none.
    """

    preset: str = "best"
    k: int | str = "auto"
    weight: float | str = "auto"
    detail: float | str = "auto"
    cues: str = "fusion"
    method: str = PAPER_METHOD
    seed: int = 0
    depth_scale: str = ""
    disparity_scale: str = ""
    intrinsics: str = ""
    calib: str = ""


def read_wishes(content: object) -> Wishes:
    """Check the settings of a request.

    Parameters
    ----------
    content : object
        What the JSON text of the request was read as.

    Returns
    -------
    Wishes

    Raises
    ------
    GeohueError
        For anything but an object with fields of `Wishes`, each of its own kind.

    Examples
    --------
    >>> read_wishes({"preset": "paper", "k": 5}).k
    5
    >>> read_wishes({"calib": "/etc/passwd"})
    Traceback (most recent call last):
    geohue.errors.GeohueError: calib is '/etc/passwd': expected numbers, or send a file
    """
    if not isinstance(content, Mapping):
        raise GeohueError("settings: expected a JSON object")
    known = {field.name for field in fields(Wishes)}
    unknown = sorted(str(name)[:40] for name in set(content) - known)
    if unknown:
        raise GeohueError(
            f"settings: no field {unknown[0]!r}; there are {', '.join(sorted(known))}"
        )
    given = {name: _CHECKS[name](name, value) for name, value in content.items()}
    return Wishes(**given)


def _number(value: object) -> bool:
    plain = isinstance(value, int | float) and not isinstance(value, bool)
    return plain and math.isfinite(float(value))  # type: ignore[arg-type]


def _refused(name: str, value: object, wanted: str) -> GeohueError:
    return GeohueError(f"{name} is {str(value)[:60]!r}: expected {wanted}")


def _one_of(*choices: str) -> Any:
    def check(name: str, value: object) -> object:
        if value not in choices:
            raise _refused(name, value, ", ".join(choices))
        return value

    return check


def _count(name: str, value: object) -> object:
    whole = isinstance(value, int) and not isinstance(value, bool)
    if value == "auto" or (whole and 1 <= value <= 255):  # type: ignore[operator]
        return value
    raise _refused(name, value, '"auto" or a whole number from 1 to 255')


def _weight(name: str, value: object) -> object:
    if value in RULES or (_number(value) and 0 <= value <= 1e9):  # type: ignore[operator]
        return value
    raise _refused(name, value, f"{', '.join(RULES)}, or a number from 0 to 1e9")


def _detail(name: str, value: object) -> object:
    if value in tuple(DETAILS) or (_number(value) and abs(value) <= 1e9):  # type: ignore[arg-type]
        return value
    raise _refused(name, value, f"{', '.join(DETAILS)} or a number")


def _seed(name: str, value: object) -> object:
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 31:
        return value
    raise _refused(name, value, "a whole number from 0 to 2147483647")


def _method(name: str, value: object) -> object:
    from geohue.segmentation.clusterers import known_methods

    return _one_of(*known_methods())(name, value)


def _preset(name: str, value: object) -> object:
    return _one_of(*PRESETS)(name, value)  # asked late: packages may add some


def _matching(pattern: re.Pattern[str], wanted: str) -> Any:
    def check(name: str, value: object) -> object:
        if value == "" or (isinstance(value, str) and pattern.fullmatch(value)):
            return value
        raise _refused(name, value, wanted)

    return check


_CHECKS: dict[str, Any] = {
    "preset": _preset,
    "k": _count,
    "weight": _weight,
    "detail": _detail,
    "cues": _one_of(*CUES),
    "method": _method,
    "seed": _seed,
    "depth_scale": _matching(_UNIT, "metres per unit, or a name such as tum"),
    "disparity_scale": _matching(_UNIT, "pixels per unit, such as 1/256"),
    # A text that is no list of numbers would be taken for the name of a file.
    "intrinsics": _matching(_NUMBERS, "numbers, or send a file"),
    "calib": _matching(_NUMBERS, "numbers, or send a file"),
}
