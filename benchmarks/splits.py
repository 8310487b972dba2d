"""Which public frames constants are fitted on, and which they are tested on: `splits.json`.

    python -m benchmarks.splits [--check] DATA

writes the file anew from the folders nyuv2, mosd, maize and rooms in DATA, or checks that it is
what they give. `part("nyuv2", "fit")` reads it.

The rule needs nothing but names, and was fixed before anything was fitted. Names that show the
same scene are one group: NYU frames are numbered room by room, so that numbers at most `REACH`
apart are one group; the labels of one room's parts and objects are one group; everything else
stands alone. The table tops of mosd come in four kinds, each split by itself. The groups of a kind
come in the order of the SHA-256 of "folder/first name", and each goes to "fit" as long as "fit"
holds at most half of the kind's names, else to "test". What is odd is tested: the one room, and one
more plant and one more table top than are fitted on.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import textwrap
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Literal, TypeAlias

Part: TypeAlias = Literal["fit", "test"]

FILE = Path(__file__).with_name("splits.json")

PARTS: tuple[Part, ...] = ("fit", "test")

REACH = 3
"""Largest step between the numbers of two NYU frames that count as one room. The data set has 3.1
frames a room, one after the other; which room a frame shows is not in the folder."""

MOSD_KINDS = (17, 25, 33)
"""First numbers of stacked boxes, occluded things and round things; single boxes come first."""


def part(folder: str, name: Part) -> tuple[str, ...]:
    """Names of the frames or clouds (without suffix) of a folder that belong to a part, sorted.

    Raises
    ------
    KeyError
        For a folder or part that the file does not have.

    Examples
    --------
    >>> part("maize", "fit")[:2]
    ('plant11', 'plant13')
    """
    return _read()[folder][name]


def is_in(folder: str, name: str, wanted: Part) -> bool:
    """Whether a frame or cloud belongs to a part.

    Raises
    ------
    KeyError
        If the file does not name it in any part.
    """
    for each in PARTS:
        if name in part(folder, each):
            return each == wanted
    raise KeyError(f"{folder}/{name} is in no part of {FILE.name}")


def split(folder: str, names: Iterable[str]) -> dict[Part, tuple[str, ...]]:
    """Split the names of a folder by the rule at the top of this file."""
    fit: list[str] = []
    test: list[str] = []
    kinds: dict[int, list[str]] = {}
    for name in sorted(names):
        kinds.setdefault(_kind(folder, name), []).append(name)
    for alike in kinds.values():
        full = len(fit) + len(alike) // 2
        for group in sorted(_groups(folder, alike), key=lambda group: _hash(folder, group[0])):
            (fit if len(fit) + len(group) <= full else test).extend(group)
    return {"fit": tuple(sorted(fit)), "test": tuple(sorted(test))}


def _kind(folder: str, name: str) -> int:
    """Which of the kinds of `MOSD_KINDS`; all else is of one kind."""
    return bisect_right(MOSD_KINDS, int(name.removeprefix("learn"))) if folder == "mosd" else 0


def _groups(folder: str, names: Sequence[str]) -> list[list[str]]:
    """Names that show one scene, in one group."""
    groups: list[list[str]] = []
    for name in names:
        if groups and _same_scene(folder, groups[-1][-1], name):
            groups[-1].append(name)
        else:
            groups.append([name])
    return groups


def _same_scene(folder: str, before: str, name: str) -> bool:
    if folder == "nyuv2":
        return int(name) - int(before) <= REACH
    return folder == "rooms" and before.split("_")[0] == name.split("_")[0]


def _hash(folder: str, name: str) -> str:
    return hashlib.sha256(f"{folder}/{name}".encode()).hexdigest()


def _names(data: Path) -> dict[str, list[str]]:
    frames = {folder: (data / folder / "frames").iterdir() for folder in ("nyuv2", "mosd")}
    clouds = {folder: (data / folder).glob("*.ply") for folder in ("maize", "rooms")}
    return {folder: sorted(p.stem for p in paths) for folder, paths in {**frames, **clouds}.items()}


def _text(splits: dict[str, dict[Part, tuple[str, ...]]]) -> str:
    """JSON with many names a line."""
    folders = []
    for folder, parts in splits.items():
        lists = [f'  "{name}": [{_lines(names)}]' for name, names in parts.items()]
        folders.append(f' "{folder}": {{\n' + ",\n".join(lists) + "\n }")
    return "{\n" + ",\n".join(folders) + "\n}\n"


def _lines(names: Sequence[str]) -> str:
    text = ", ".join(json.dumps(name) for name in names)
    filled = textwrap.fill(text, 100, initial_indent="   ", subsequent_indent="   ")
    return f"\n{filled}\n  " if names else ""


@cache
def _read() -> dict[str, dict[Part, tuple[str, ...]]]:
    stored = json.loads(FILE.read_text())
    return {
        folder: {part: tuple(parts[part]) for part in PARTS} for folder, parts in stored.items()
    }


def main() -> None:
    """Write the file, or check it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    text = _text({folder: split(folder, names) for folder, names in _names(given.data).items()})
    if not given.check:
        FILE.write_text(text)
    elif text != FILE.read_text():
        raise SystemExit(f"{FILE.name} is not what the names in {given.data} give")


if __name__ == "__main__":
    main()
