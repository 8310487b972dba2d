"""The built page in the package is what its source gives."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STATIC = ROOT / "src/geohue/web/static"
TOOLS = ROOT / "web/node_modules"


@pytest.mark.skipif(
    shutil.which("npm") is None or not (TOOLS / "esbuild").exists(), reason="npm ci in web/ first"
)
def test_the_source_gives_the_same_bytes(tmp_path: Path) -> None:
    place = tmp_path / "web"
    ignored = shutil.ignore_patterns("node_modules")
    shutil.copytree(ROOT / "web", place, ignore=ignored)
    (place / "node_modules").symlink_to(TOOLS)
    (tmp_path / "src/geohue/web/static").mkdir(parents=True)
    subprocess.run(["npm", "run", "--silent", "build"], cwd=place, check=True, capture_output=True)
    built = tmp_path / "src/geohue/web/static"
    assert {f.name for f in built.iterdir()} == {f.name for f in STATIC.iterdir()}
    for file in built.iterdir():
        assert file.read_bytes() == (STATIC / file.name).read_bytes(), f"{file.name}: make web"


def test_nothing_in_the_page_is_loaded_from_elsewhere() -> None:
    for file in STATIC.iterdir():
        found = set(re.findall(r"(?:https?:)?//[\w.-]+\.[a-z]{2,}", file.read_text()))
        assert found <= {"http://www.w3.org"}, file.name  # a name space, never asked for
    page = (STATIC / "index.html").read_text()
    assert "<style" not in page
    assert " style=" not in page
    assert not re.search(r"<script(?![^>]*src=)", page)
    assert not re.search(r" on\w+=", page)


def test_the_lock_file_names_no_place_to_download_from() -> None:
    text = (ROOT / "web/package-lock.json").read_text()
    assert "resolved" not in text
    packages = json.loads(text)["packages"]
    assert all("integrity" in entry for name, entry in packages.items() if name)
