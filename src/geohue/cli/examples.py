"""What ``--help`` of each command shows before its options: two examples."""

from __future__ import annotations

from collections.abc import Callable
from inspect import cleandoc
from typing import Any

EXAMPLES = {
    "segment": (
        "geohue segment rgb.png depth.png --intrinsics camera.json -o out",
        "geohue segment scan.ply --detail fine -o out",
    ),
    "batch": (
        "geohue batch frames/ -o out",
        "geohue batch frames/ -o out --lean --processes 4 --resume",
    ),
    "superpoints": (
        "geohue superpoints scan.ply --count 3000,300,30 -o out",
        "geohue superpoints rgb.png depth.png --size 400 -o out",
    ),
    "video": (
        "geohue video sequence/ -o out --preset fast",
        "geohue video sequence/ -o out --resume",
    ),
    "serve": (
        "geohue serve",
        "geohue serve --port 8080 --workers 2",
    ),
    "compare": (
        "geohue compare rgb.png depth.png -k 5 -o plates",
        "geohue compare --sample boxes --methods best,kmeans",
    ),
    "register": (
        "geohue register rgb.png depth.png --calib rig.yml -o registered",
        "geohue register rgb.png depth.png --calib rig.yml --refine -o out",
    ),
    "calibrate": (
        "geohue calibrate left*.jpg right*.jpg --pattern 9x6 -o stereo",
        "geohue calibrate ir*.png rgb*.png --rig --square 0.025 -o rig",
    ),
    "evaluate": (
        "geohue evaluate out/labels.png truth.png",
        "geohue evaluate results/ truth/ --objects --json",
    ),
    "benchmark": (
        "geohue benchmark frames/ -o out --methods nncsc,kmeans",
        "geohue benchmark nyu/ -o out --protocol nyu --limit 20",
    ),
    "info": (
        "geohue info rgb.png depth.png --intrinsics camera.json",
        "geohue info scan.laz --json",
    ),
    "warm": (
        "geohue warm",
        "NUMBA_CACHE_DIR=/cache geohue warm",
    ),
}
"""Lines short enough for a terminal of 80 columns."""


_VALUES = {"path": "FILE", "int": "N", "float": "NUMBER"}
"""What an option takes, by its type."""


def help_of(command: Callable[..., Any]) -> str:
    """Return the help of a command: what it does, two examples, and the rest of its docstring.

    Paragraphs are single lines, which the terminal breaks as wide as it is.

    Examples
    --------
    >>> def warm() -> None:
    ...     "Compile every loop."
    >>> help_of(warm).splitlines()[2:5] == [chr(8), "Examples:", "  geohue warm"]
    True
    """
    text = cleandoc(command.__doc__ or "")
    first, *rest = (" ".join(part.split()) for part in text.split("\n\n"))
    lines = EXAMPLES.get(command.__name__, ())
    shown = "\n".join(f"  {line}" for line in lines)
    parts = [first, f"\b\nExamples:\n{shown}" if lines else "", *rest]
    return "\n\n".join(part for part in parts if part)


def name_value(param: Any) -> None:
    """Say what a parameter takes, where its declaration leaves that to the name of a type."""
    if param.metavar is None:
        known = getattr(param, "type_descriptor", None)  # of later versions of typer
        kind = str(getattr(param, "type", "") if known is None else known.annotation)
        taken = next((name for part, name in _VALUES.items() if part in kind.lower()), "NAME")
        param.metavar = " " if getattr(param, "is_flag", False) else taken
    elif param.param_type_name == "argument" and not param.required:
        param.metavar = param.metavar.removeprefix("[").removesuffix("]")  # brackets are added
