"""What the library says of its arguments, said of the options of the command line."""

from __future__ import annotations

import re

_OPTIONS = {
    "k": "-k",
    "weight": "--lambda",
    "format": "--format",
    "formats": "--format",
} | {
    name: f"--{name}"
    for name in (
        *("preset", "cues", "method", "seed", "detail", "components"),
        *("memory", "processes", "scheduler", "layout", "views", "limit"),
    )
}
_NAMES = "|".join(sorted(_OPTIONS, key=len, reverse=True))
_VALUE = r"""('[^']*'|"[^"]*"|[-+.\w]+)"""

_PATTERNS = (
    (re.compile(r"\b(overwrite|resume|lean)=True\b"), r"--\1"),
    (re.compile(rf"\b({_NAMES})={_VALUE}"), None),  # weight="agreement"
    (re.compile(rf"\b({_NAMES}) is {_VALUE}"), None),  # k is 0
    (re.compile(r"\b(preset|cues|method|format|layout) ('[^']*'|\"[^\"]*\")"), None),
    (re.compile(r"\b(lower|and|or|of) (k)(?=$|[ ,;:.])"), r"\1 -k"),
    (re.compile(r"\b(leave out|or) the (detail|method|preset)\b"), r"\1 --\2"),
    (re.compile(r"\b(leave out|or) the weight\b"), r"\1 --lambda"),
    (re.compile(rf"\ba weight of {_VALUE}"), r"--lambda \1"),
    (re.compile(r"\b(or|not) '([-+.\w]+)'"), r"\1 \2"),
)


def of_options(message: str) -> str:
    """Return a message of the library with options in place of arguments.

    Examples
    --------
    >>> of_options('k is 0: expected "auto" or a whole number from 1 to 255')
    '-k 0: expected "auto" or a whole number from 1 to 255'
    >>> of_options('weight="consensus" needs the cloud in memory: choose weight="agreement"')
    '--lambda consensus needs the cloud in memory: choose --lambda agreement'
    >>> of_options("method 'svm': choose one of nncsc, kmeans")
    '--method svm: choose one of nncsc, kmeans'
    """
    for pattern, text in _PATTERNS:
        message = pattern.sub(_option if text is None else text, message)
    return message


def _option(found: re.Match[str]) -> str:
    return f"{_OPTIONS[found[1]]} {found[2].strip(chr(39) + chr(34))}"
