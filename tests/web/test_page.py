"""The page in a real browser: each kind of input, the slider, corrections, what is taken home."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.typing import NDArray

import geohue
from geohue import Scene
from geohue.read.clouds.cloud import read_cloud
from geohue.read.images.pictures import read_labels
from geohue.results.png import write_png
from web.client import Client
from web.conftest import OpenPage

pytest.importorskip("playwright.sync_api")

if TYPE_CHECKING:
    from playwright.sync_api import Page

AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"


def _result(page: Page, text: str = "") -> str:
    """Wait for a result, and return what is said of it."""
    page.wait_for_function(
        "text => document.getElementById('told').textContent.includes(text || 'segment') && "
        "document.getElementById('working').hidden",
        arg=text,
    )
    return page.inner_text("#told")


def _modes(page: Page) -> list[str]:
    return page.locator("#modes [role=radio]").all_inner_texts()


def _count(page: Page) -> int:
    return int(page.inner_text("#count").split()[0])


def _slide(page: Page, slider: str, value: float) -> None:
    page.eval_on_selector(
        slider,
        "(e, v) => { e.value = v; e.dispatchEvent(new Event('input'));"
        " e.dispatchEvent(new Event('change')); }",
        value,
    )


def _taken(page: Page, name: str, folder: Path) -> Path:
    with page.expect_download() as found:
        page.click(f"#exports [data-format={name}]")
    file = folder / found.value.suggested_filename
    found.value.save_as(file)
    return file


def _same_parts(one: NDArray[np.int32], other: NDArray[np.int32]) -> bool:
    pairs = np.unique(np.stack([one.ravel(), other.ravel()]), axis=1)
    return len(pairs[0]) == len(np.unique(one)) == len(np.unique(other))


def _pixels(page: Page) -> bytes:
    """The 3-D view once it is at rest."""
    page.wait_for_timeout(250)
    return page.screenshot(clip=page.locator("#panes").bounding_box())


@pytest.fixture
def framed(open_page: OpenPage, frame: Path) -> Page:
    """The page with the frame segmented."""
    page = open_page()
    page.set_input_files("#files", [frame / "color.png", frame / "depth.png"])
    _result(page)
    return page


@pytest.fixture(scope="module")
def expected(frame_scene: Scene) -> geohue.Segmentation:
    return geohue.segment(frame_scene)


def test_an_image_with_depth_gives_the_segments_of_the_library(
    framed: Page, expected: geohue.Segmentation, tmp_path: Path
) -> None:
    assert _count(framed) == expected.k
    assert _modes(framed) == ["Colour", "Depth", "Segments", "Borders", "Votes", "3-D"]
    labels = read_labels(_taken(framed, "labels", tmp_path)) - 1
    assert _same_parts(labels, expected.labels)
    assert np.bincount(labels.ravel()).tolist() == np.bincount(expected.labels.ravel()).tolist()


def test_the_slider_cuts_the_tree_as_the_library_does(
    framed: Page, expected: geohue.Segmentation, tmp_path: Path
) -> None:
    assert expected.levels is not None
    for detail in (-1.0, 2.0, 3.0):
        _slide(framed, "#detail", detail)
        set_to = float(framed.input_value("#detail"))
        assert _count(framed) == expected.levels.count(set_to)
        labels = read_labels(_taken(framed, "labels", tmp_path)) - 1
        assert _same_parts(labels, expected.levels.at(set_to))
    framed.click("#undo")
    framed.click("#undo")
    assert _count(framed) == expected.levels.count(-1.0)


def test_each_view_is_painted_and_has_no_alarm(framed: Page) -> None:
    seen = set()
    for mode in _modes(framed):
        framed.get_by_role("radio", name=mode, exact=True).click()
        seen.add(_pixels(framed))
    assert len(seen) == 6
    assert framed.locator("#message").is_hidden()


def test_a_stereo_pair_is_matched(open_page: OpenPage, pair: Path) -> None:
    page = open_page()
    page.set_input_files("#files", [pair / "right.png", pair / "left.png"])
    _result(page)
    assert "3-D" in _modes(page)
    page.click("#settings summary")
    assert page.locator("#roles select").evaluate_all("all => all.map(e => e.value)") == [
        "color",
        "right",
    ]


@pytest.mark.parametrize("painter", ["plain", "gl"])
def test_a_cloud_turns_and_is_colored_in_four_ways(
    open_page: OpenPage, cloud: Path, tmp_path: Path, painter: str
) -> None:
    page = open_page(f"?draw={painter}")
    page.set_input_files("#files", cloud)
    assert "2 segments" in _result(page)
    assert _modes(page) == ["3-D"]
    assert page.locator("#exports [data-format=coco]").is_hidden()
    seen = {_pixels(page)}
    for way in ("color", "depth", "normals"):
        page.select_option("#paint", way)
        seen.add(_pixels(page))
    page.select_option("#paint", "segment")
    view = page.locator(".pane canvas:not(.flat)")
    assert view.get_attribute("data-painter") == painter
    view.focus()
    for key in ("ArrowLeft", "Shift+ArrowUp", "+"):
        page.keyboard.press(key)
        seen.add(_pixels(page))
    box = view.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 80, y + 20, steps=4)
    page.mouse.up()
    page.mouse.wheel(0, 200)
    seen.add(_pixels(page))
    assert len(seen) == 8
    page.wait_for_function("e => e.dataset.drawn === '3000'", arg=view.element_handle())
    _slide(page, "#detail", 0)
    assert read_cloud(_taken(page, "ply", tmp_path)).points.shape == (3000, 3)


@pytest.mark.parametrize("painter", ["plain", "gl"])
def test_points_are_picked_in_the_3d_view(open_page: OpenPage, cloud: Path, painter: str) -> None:
    page = open_page(f"?draw={painter}")
    page.set_input_files("#files", cloud)
    _result(page)
    page.wait_for_timeout(300)
    box = page.locator("#panes").bounding_box()
    assert box is not None
    found = set()
    for share in np.linspace(0.1, 0.9, 17):
        page.mouse.move(box["x"] + share * box["width"], box["y"] + box["height"] / 2)
        found.add(page.inner_text("#hover").split(" · ")[0].strip())
    assert {"segment 1", "segment 2"} <= found


def test_an_image_alone_is_split_by_colour(open_page: OpenPage, frame: Path) -> None:
    page = open_page()
    page.set_input_files("#files", frame / "color.png")
    _result(page)
    assert "3-D" not in _modes(page)
    assert page.locator("#exports [data-format=ply]").is_disabled()


def test_hover_tells_of_a_segment_and_a_click_selects_it(framed: Page) -> None:
    box = framed.locator("#panes").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    framed.mouse.move(x, y)
    words = framed.inner_text("#hover")
    for word in ("pixels", "%", "mean colour", "extent", "neighbour"):
        assert word in words
    framed.mouse.click(x, y)
    assert words.split(" · ")[1] in framed.inner_text("#selection")
    assert framed.locator("#segments [aria-pressed=true]").count() == 1


def test_corrections_can_be_undone_and_are_taken_home(framed: Page, tmp_path: Path) -> None:
    rows = framed.locator("#segments button")
    k = rows.count()
    assert k == _count(framed) >= 2
    rows.nth(0).click()
    framed.fill("#name", "wall")
    framed.keyboard.press("Enter")
    rows.nth(1).click(modifiers=["Shift"])
    framed.click("#merge")
    assert rows.count() == k - 1
    framed.click("#split")
    assert rows.count() == k
    framed.click("#undo")
    framed.click("#undo")
    assert rows.count() == k
    framed.click("#redo")
    assert rows.count() == k - 1
    table = json.loads(_taken(framed, "json", tmp_path).read_text())["segments"]
    assert len(table) == k - 1
    assert [row["name"] for row in table].count("wall") == 1
    framed.keyboard.press("z")
    rows.nth(0).click()
    framed.click("#split")
    assert rows.count() == k + 1


def test_segments_can_be_hidden_and_looked_at_alone(framed: Page) -> None:
    whole = _pixels(framed)
    rows = framed.locator("#segments button")
    hidden = framed.locator("#segments .gone")
    rows.nth(0).click()
    framed.click("#isolate")
    assert hidden.count() == rows.count() - 1
    assert _pixels(framed) != whole
    framed.click("#showall")
    framed.click("#hide")
    assert hidden.count() == 1
    framed.keyboard.press("a")
    assert hidden.count() == 0


def test_the_report_opens_anywhere(framed: Page, tmp_path: Path) -> None:
    file = _taken(framed, "report", tmp_path)
    asked: list[str] = []
    other = framed.context.new_page()
    other.on("request", lambda request: asked.append(request.url))
    other.set_content(file.read_text())
    assert other.inner_text("h1") == f"{_count(framed)} segments"
    assert other.locator("img").first.evaluate("e => e.naturalWidth") > 0
    assert [url for url in asked if not url.startswith("data:")] == []


def test_every_export_comes_as_a_file(framed: Page, tmp_path: Path) -> None:
    for name in ("npy", "ply", "las", "coco"):
        assert _taken(framed, name, tmp_path).stat().st_size > 100


def test_a_broken_and_a_too_large_file_are_one_message(
    open_page: OpenPage, tmp_path: Path, frame: Path
) -> None:
    page = open_page()
    broken = tmp_path / "color.png"
    broken.write_bytes((frame / "color.png").read_bytes()[:900])
    page.set_input_files("#files", broken)
    page.wait_for_selector("#message:not([hidden])")
    assert "color.png: is cut short or damaged" in page.inner_text("#message")
    large = tmp_path / "large.png"
    large.write_bytes(bytes(3 << 20))
    page.set_input_files("#files", large)
    page.wait_for_function("() => document.getElementById('message').textContent.includes('MB')")
    assert "more than 2.0 MB" in page.inner_text("#message")
    other = tmp_path / "words.doc"
    other.write_text("no scene")
    page.set_input_files("#files", other)
    page.wait_for_function("() => document.getElementById('message').textContent.includes('None')")


def test_long_work_shows_its_stage_and_can_be_cancelled(open_page: OpenPage, frame: Path) -> None:
    page = open_page()
    page.select_option("#sample", "motorcycle-matched")
    page.wait_for_selector("#working:not([hidden])")
    page.wait_for_function("() => document.getElementById('stage').textContent.includes('reading')")
    page.click("#cancel")
    page.wait_for_selector("#message:not([hidden])")
    assert page.inner_text("#message") == "Cancelled."
    assert page.locator("#working").is_hidden()
    page.set_input_files("#files", frame / "color.png")
    _result(page)


def test_two_tabs_do_not_mix(open_page: OpenPage, frame: Path, cloud: Path) -> None:
    one, other = open_page(), open_page()
    one.set_input_files("#files", cloud)
    other.set_input_files("#files", [frame / "color.png", frame / "depth.png"])
    _result(one)
    _result(other)
    assert _modes(one) == ["3-D"]
    assert len(_modes(other)) == 6
    other.locator("#segments button").nth(0).click()
    assert "pixels" in other.inner_text("#selection")
    assert "points" not in other.inner_text("#selection")
    assert "Click a segment" in one.inner_text("#selection")


def test_the_files_go_with_the_page(open_page: OpenPage, frame: Path, client: Client) -> None:
    page = open_page()
    with page.expect_response(lambda r: r.url.endswith("/result")) as asked:
        page.set_input_files("#files", frame / "color.png")
    _result(page)
    assert client.http.get(asked.value.url).status_code == 200
    page.goto("about:blank")
    latest = monotonic() + 10
    while client.http.get(asked.value.url).status_code != 404:
        assert monotonic() < latest
        sleep(0.05)


def test_two_settings_are_seen_beside_each_other(framed: Page) -> None:
    alone = _pixels(framed)
    framed.select_option("#against", "preset:paper")
    framed.click("#compare")
    framed.wait_for_selector("#alone:not([hidden])")
    beside = {_pixels(framed)}
    for share in (0, 100):
        _slide(framed, "#divider", share)
        beside.add(_pixels(framed))
    assert len(beside | {alone}) == 4
    framed.click("#alone")
    assert framed.locator(".pane").count() == 1


def test_the_curve_of_q_walks_over_its_cuts(open_page: OpenPage, frame: Path) -> None:
    page = open_page()
    page.click("#settings summary")
    page.select_option("#preset", "paper")
    page.fill("#k", "3")
    page.set_input_files("#files", [frame / "color.png", frame / "depth.png"])
    first = _result(page)
    assert page.locator("#curve .chosen").count() == 1
    assert page.locator("#nolevels").is_visible()
    chosen = page.input_value("#weights")
    _slide(page, "#weights", 0 if chosen != "0" else 1)
    second = _result(page, "weight 0" if chosen != "0" else "weight")
    page.wait_for_function("t => document.getElementById('told').textContent !== t", arg=first)
    assert page.locator("#curvebox").is_visible()
    assert "3 segments" in second
    _slide(page, "#weights", int(chosen))
    page.wait_for_function("t => document.getElementById('told').textContent === t", arg=first)


def test_a_folder_is_stepped_through(open_page: OpenPage, tmp_path: Path) -> None:
    (tmp_path / "rgb").mkdir()
    (tmp_path / "depth").mkdir()
    for i, step in enumerate((1, 2, 3)):
        write_png(tmp_path / "rgb" / f"{i}.png", np.full((20, 30 * step, 3), 90, np.uint8))
        write_png(tmp_path / "depth" / f"{i}.png", np.full((20, 30 * step), 900, np.uint16))
    page = open_page()
    page.set_input_files("#folder", tmp_path)
    for i in range(3):
        page.wait_for_function(
            "w => document.querySelector('.pane canvas.flat')?.width === w", arg=30 * (i + 1)
        )
        assert f"{i + 1} of 3" in page.inner_text("#frame")
        assert "Depth" in _modes(page)
        page.click("#later")
    page.click("#earlier")
    page.wait_for_function("() => document.querySelector('.pane canvas.flat').width === 60")


def test_the_views_and_the_list_can_be_used_by_keys_alone(framed: Page) -> None:
    framed.locator("#modes [aria-checked=true]").focus()
    framed.keyboard.press("ArrowRight")
    assert framed.inner_text("#modes [aria-checked=true]") == "Borders"
    framed.keyboard.press("1")
    assert framed.inner_text("#modes [aria-checked=true]") == "Colour"
    framed.locator("#segments button").first.focus()
    framed.keyboard.press("Enter")
    assert framed.locator("#segments [aria-pressed=true]").count() == 1
    assert framed.evaluate("document.activeElement.dataset.segment") is not None
    before = _count(framed)
    framed.locator("#detail").focus()
    framed.keyboard.press("End")
    assert _count(framed) > before


@pytest.mark.skipif(not AXE.exists(), reason="no axe-core: npm ci in web/")
@pytest.mark.parametrize(
    "options",
    [
        {"color_scheme": "light"},
        {"color_scheme": "dark"},
        {"viewport": {"width": 390, "height": 844}},
    ],
)
def test_axe_finds_nothing_serious(
    open_page: OpenPage, frame: Path, options: dict[str, Any]
) -> None:
    size = options.pop("viewport", None)
    page = open_page(**options)
    if size:
        page.set_viewport_size(size)
    page.evaluate(AXE.read_text())
    for step in (None, [frame / "color.png", frame / "depth.png"]):
        if step:
            page.set_input_files("#files", step)
            _result(page)
            page.locator("#segments button").first.click()
            page.click("#settings summary")
        found = page.evaluate("async () => await axe.run()")
        assert len(found["passes"]) > 15
        serious = [v for v in found["violations"] if v["impact"] in ("serious", "critical")]
        shown = [(v["id"], [n["html"][:120] for n in v["nodes"][:3]]) for v in serious]
        assert shown == []
    wide = page.evaluate("document.documentElement.scrollWidth - innerWidth")
    assert wide <= 0, "the page scrolls sideways"
