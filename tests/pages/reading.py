"""The pages of the documentation, and the blocks of code in them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
DOCS = sorted([*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "studies").glob("*.md")])
PAGES = [ROOT / "README.md", ROOT / "BENCHMARKS.md", *DOCS]

_FENCE = re.compile(r"^```(?P<language>[^\n]*)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)


class Block(NamedTuple):
    """A fenced block: where it begins, its language ("" for commands) and its text."""

    page: Path
    line: int
    language: str
    text: str


def blocks(page: Path) -> Iterator[Block]:
    """Find the blocks of a page, in their order."""
    text = page.read_text("utf-8")
    for found in _FENCE.finditer(text):
        line = text.count("\n", 0, found.start()) + 2
        yield Block(page, line, found["language"], found["text"])


def commands(block: Block) -> Iterator[tuple[int, list[str]]]:
    """Find the commands of geohue in a block: the line and the arguments after ``geohue``."""
    joined = block.text.replace("\\\n", " ")
    for at, line in enumerate(joined.splitlines()):
        words = shlex.split(line, comments=True) if line.startswith("geohue ") else []
        if words:
            yield block.line + at, words[1:]
