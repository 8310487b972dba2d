"""What a comparison leaves behind: page, tables, labels."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Scene
from geohue.read.images.pictures import read_color, read_labels
from geohue.studies.compare import Comparison
from geohue.studies.compare.files import write_comparison

Boxes = tuple[Scene, NDArray[np.int32]]
TITLE = 'Scene <script>alert("1")</script> & more'


class Reader(HTMLParser):
    """Collects cells, sources and text, and checks that tags close."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.cells: dict[str, str] = {}
        self.sources: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = dict(attrs)
        if tag == "td" and "id" in named:
            self.cells[str(named["id"])] = str(named["class"])
        if tag == "img":
            self.sources.append(str(named["src"]))
        if tag not in ("img", "meta"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def folder(
    faulty: Comparison, three_boxes: Boxes, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    out = tmp_path_factory.mktemp("plate") / "new"
    scene, truth = three_boxes
    noted = replace(faulty, warnings=("1 < 2 & 3",))
    files = write_comparison(out, scene, noted, truth + 1, TITLE)
    assert all(file.is_file() for file in files)
    assert sorted(p for p in out.rglob("*") if p.is_file()) == sorted(files)
    return out


def test_the_page_has_every_cell_and_needs_nothing_else(folder: Path, faulty: Comparison) -> None:
    text = (folder / "compare.html").read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    assert reader.cells == {result.cell.name: result.status for result in faulty.results}
    assert len(reader.sources) == 3 + 3
    assert all(source.startswith("data:image/jpeg;base64,") for source in reader.sources)
    assert "http" not in text
    assert "<script" not in text


def test_text_is_escaped(folder: Path) -> None:
    text = (folder / "compare.html").read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(text)
    for part in (TITLE, "<b>no & luck</b>", "1 < 2 & 3"):
        assert part in reader.text
        assert part not in text


def test_tables(folder: Path, faulty: Comparison) -> None:
    content = json.loads((folder / "compare.json").read_text())
    assert content["cells"] == [result.row() for result in faulty.results]
    with (folder / "compare.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["method"] for row in rows] == [r.cell.method for r in faulty.results]
    assert float(rows[0]["rand"]) == faulty.results[0].scores["rand"]
    assert (rows[2]["status"], rows[2]["regions"]) == ("failed", "")


def test_labels_and_plate(folder: Path, faulty: Comparison) -> None:
    names = sorted(file.name for file in (folder / "labels").iterdir())
    assert names == ["edison-color.png", "nncsc-color.png", "nncsc-fusion.png"]
    labels = faulty.at("nncsc", "fusion").labels
    assert labels is not None
    np.testing.assert_array_equal(read_labels(folder / "labels/nncsc-fusion.png") - 1, labels)
    assert read_color(folder / "plate.png").shape[1] > 3 * 320


def test_a_folder_that_cannot_be_made(
    faulty: Comparison, three_boxes: Boxes, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("here")
    with pytest.raises(GeohueError, match="cannot be made"):
        write_comparison(tmp_path / "file" / "out", three_boxes[0], faulty)
