"""The figures that are quoted are the figures that were measured."""

from __future__ import annotations

import re

import pytest

from pages.reading import ROOT

README = (ROOT / "README.md").read_text("utf-8")
FRONT = (ROOT / "BENCHMARKS.md").read_text("utf-8")
SECTIONS = re.findall(r"^## (\d+\. [^\n]*)\n(.*?)(?=^## )", FRONT, re.DOTALL | re.MULTILINE)
NUMBER = r"(?<![\w.,^])\d[\d,]*(?:\.\d+)?(?![\w.]*\d)"


def test_the_readme_quotes_the_study(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT)
    from benchmarks.figures import STUDY, measured

    voi = r"([\d.]+)"
    quoted = re.search(
        rf"On (\d+) frames of NYU Depth V2 that they were not fitted on, `best` has a variation "
        rf"of information of {voi} bits \(`paper` {voi}\), on (\d+) table tops {voi} \({voi}\), "
        rf"and on these as bare clouds {voi} \({voi}\)",
        " ".join(README.split()),
    )
    assert quoted
    found = measured(STUDY.read_text("utf-8"))
    for at, scenes in ((2, "nyuv2"), (5, "mosd"), (7, "mosd as clouds")):
        for i, preset in ((at, "best"), (at + 1, "paper")):
            assert float(quoted[i]) == pytest.approx(found[scenes, preset][1], abs=0.0051)
    assert (int(quoted[1]), int(quoted[4])) == (found["nyuv2", "best"][0], found["mosd", "best"][0])


def test_there_are_ten_figures() -> None:
    assert [int(title.split(".")[0]) for title, _ in SECTIONS] == list(range(1, 11))


@pytest.mark.parametrize("text", [pytest.param(text, id=title) for title, text in SECTIONS])
def test_each_figure_has_a_command_and_stands_in_its_study(text: str) -> None:
    assert "```\npython" in text
    pages = re.findall(r"\]\((docs/[^)#]+\.md)", text)
    assert pages
    known = "\n".join((ROOT / page).read_text("utf-8") for page in pages)
    prose = re.sub(r"```.*?```|`[^`]*`|\]\([^)]*\)", "", text, flags=re.DOTALL)
    missing = [n for n in re.findall(NUMBER, prose) if n not in re.findall(NUMBER, known)]
    assert not missing
