"""What a release states in several places is the same in all of them."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

import geohue

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def project() -> dict[str, Any]:
    table: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    return table


def test_the_citation_and_the_recipe_have_the_version() -> None:
    for name in ("CITATION.cff", "packaging/conda/recipe.yaml"):
        text = (ROOT / name).read_text("utf-8")
        assert re.findall(r'^\s*version: "?(\d[^"\n]*)', text, re.MULTILINE) == [geohue.__version__]


def test_the_recipe_needs_what_the_project_needs(project: dict[str, Any]) -> None:
    renamed = {"opencv-python-headless": "py-opencv", "matplotlib": "matplotlib-base"}
    needed = set()
    for entry in project["dependencies"]:
        name, bound = re.fullmatch(r"([\w-]+)(>=[\w.]+)", entry).groups()  # type: ignore[union-attr]
        needed.add(f"{renamed.get(name, name)} {bound}")
    recipe = (ROOT / "packaging/conda/recipe.yaml").read_text("utf-8")
    run = recipe.split("  run:\n")[1].split("\n\n")[0]
    assert set(re.findall(r"- (.+)", run)) - {"python >=3.11"} == needed


def test_each_extra_is_tried_alone(project: dict[str, Any]) -> None:
    extras = set(project["optional-dependencies"]) - {"dev", "docs"}
    text = (ROOT / "noxfile.py").read_text("utf-8")
    tried = re.findall(r'^    "([\w-]+)": \[', text, re.MULTILINE)
    assert set(tried) == extras
    for path in re.findall(r'"((?:tests|docs)/[^"]+)"', text):
        assert (ROOT / path).exists()


def test_each_dependency_has_a_lower_bound(project: dict[str, Any]) -> None:
    entries = list(project["dependencies"])
    for extra in project["optional-dependencies"].values():
        entries += extra
    assert [entry for entry in entries if ">=" not in entry] == []


def test_the_constraints_name_no_address() -> None:
    assert "://" not in (ROOT / "constraints.txt").read_text("utf-8")
