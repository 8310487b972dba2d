"""What the documentation shows works: each command is one that exists, each example is run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import typer

from geohue.cli.app import app
from pages.reading import DOCS, PAGES, ROOT, Block, blocks, commands

ALL = [block for page in PAGES for block in blocks(page)]
COMMANDS = [
    pytest.param(words, id=f"{block.page.name}:{line}")
    for block in ALL
    for line, words in commands(block)
]


@pytest.mark.parametrize("words", COMMANDS)
def test_each_command_is_understood(words: list[str]) -> None:
    group = typer.main.get_command(app)
    with group.make_context("geohue", [words[0], "--help"], resilient_parsing=True) as parent:
        name, command, _ = group.resolve_command(parent, list(words))  # type: ignore[attr-defined]
        arguments = [word for word in words[1:] if not word.startswith("<")]
        with command.make_context(name, arguments, parent=parent):
            pass


def run_elsewhere(block: Block) -> bool:
    """Whether it is a file of the package that tests/plugins installs, or tests/web's client."""
    is_file = re.match(r"# \w+\.py\n", block.text) is not None
    return is_file if block.page.name == "extending.md" else block.page.name == "serve.md"


@pytest.mark.parametrize(
    "block",
    [pytest.param(b, id=f"{b.page.name}:{b.line}") for b in ALL if b.language == "python"],
)
def test_each_python_example_is_one_that_is_run(block: Block) -> None:
    # Doctest runs what begins with a prompt; a block without one would be trusted unseen.
    assert block.text.lstrip().startswith(">>> ") or run_elsewhere(block)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_each_link_to_a_file_leads_somewhere(page: Path) -> None:
    targets = re.findall(r"\]\((?!https?:|#)([^)#]+)", page.read_text("utf-8"))
    missing = [t for t in targets if not (page.parent / t).exists() and "examples/" not in t]
    assert not missing


def test_each_page_is_in_the_contents() -> None:
    index = (ROOT / "docs" / "index.md").read_text("utf-8")
    listed = re.findall(r"^([a-z/-]+)$", index, re.MULTILINE)
    pages = {page.relative_to(ROOT / "docs").with_suffix("").as_posix() for page in DOCS}
    assert pages - {"index"} <= set(listed)
    assert len(listed) == len(set(listed))  # none twice


def anchors(page: Path) -> set[str]:
    """Name the headings of a page as links do."""
    text = re.sub(r"^```.*?^```$", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_each_link_to_a_heading_leads_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^):#]*\.md|)#([^)]+)\)", page.read_text("utf-8"))
    missing = [(to, at) for to, at in links if at not in anchors(page.parent / to if to else page)]
    assert not missing
