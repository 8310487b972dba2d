"""Draw the plates of Fig. 8, 9 and 11-13 for all scenes of the data folder.

    python -m benchmarks.gallery -o FOLDER [--scenes aloe,baby1] [--frames 3] [--processes 2]
    python -m benchmarks.gallery --docs docs/images

The first form writes a folder a scene, as `geohue compare` does, and an index.html. The data are
looked for as the tests do (GEOHUE_DATA, or ../shared/data). The second form draws the pictures of
README.md and docs/gallery.md from the sample that may be shipped.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

import geohue
from geohue.datasets import load_sample
from geohue.merge.levels import Levels
from geohue.read import read_color
from geohue.read.images.disparity import read_disparity
from geohue.results.atomic import atomic_write
from geohue.results.borders import paint_borders
from geohue.results.picture import overlay
from geohue.scene import Scene
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.compare import Comparison, Result, compare, draw_plate
from geohue.studies.compare.cells import all_rows
from geohue.studies.compare.files import write_comparison
from geohue.studies.compare.match import match_labels
from geohue.studies.compare.views import Image, scaled
from geohue.studies.items import Item

Truth = NDArray[np.int32] | None

_ROOT = Path(__file__).parents[1]
_FOCAL, _BASELINE = 3740.0, 0.160  # px and metres, at full size
# At full size, from SOURCE.txt of the data, but for Baby2, which has none there: within the range
# of the others (251-300). A wrong one bends the depth a little, and no border moves by it.
_DMIN = {"Aloe": 270.0, "Baby1": 300.0, "Baby2": 290.0}
_K = {"aloe": 4, "baby1": 4, "baby2": 4, "motorcycle": 5}
_JPEG_LIMIT = 300_000  # bytes


@dataclass(frozen=True, slots=True)
class Entry:
    """A scene of the gallery: its name, how to load it, and K."""

    name: str
    load: Callable[[], tuple[Scene, Truth]]
    k: int | Literal["auto"]


def entries(data: Path, frames: int) -> list[Entry]:
    """List the scenes there are: Middlebury, the sample, and some frames of mOSD and NYU."""
    found = [Entry("motorcycle", lambda: (load_sample("motorcycle"), None), _K["motorcycle"])]
    third = data / "middlebury2006_third"
    for name in _DMIN:
        if (third / name).is_dir():
            found.append(Entry(name.lower(), _middlebury(third / name), _K[name.lower()]))
    for folder in ("mosd", "nyuv2"):
        if (data / folder).is_dir():
            for frame in find_frames(data / folder, frames):
                found.append(Entry(f"{folder}-{frame.name}", _frame(frame), "auto"))
    return found


def _middlebury(folder: Path) -> Callable[[], tuple[Scene, Truth]]:
    def load() -> tuple[Scene, Truth]:
        colors = read_color(folder / "view1.png")
        values = read_disparity(folder / "disp1.png", 1.0).disparity  # full-size pixels
        depth = _FOCAL * _BASELINE / (values + _DMIN[folder.name])
        height, width = depth.shape
        camera = geohue.Intrinsics(_FOCAL / 3, _FOCAL / 3, width / 2, height / 2, width, height)
        return Scene.from_rgbd(colors, depth, camera), None

    return load


def _frame(frame: Item) -> Callable[[], tuple[Scene, Truth]]:
    return lambda: load_frame(frame)


def draw(entry: Entry, out: Path, methods: Sequence[str], processes: int) -> Comparison:
    """Compare methods on a scene and write the files."""
    scene, truth = entry.load()
    tell = _tell(entry.name)
    done = compare(scene, methods, k=entry.k, truth=truth, processes=processes, progress=tell)
    write_comparison(out / entry.name, scene, done, truth, f"Comparison: {entry.name}")
    return done


def _tell(name: str) -> Callable[[int, int, Result], None]:
    def tell(count: int, total: int, result: Result) -> None:
        text = f"{name} {count}/{total} {result.cell.name} {result.status} {result.reason}"
        print(text.rstrip(), file=sys.stderr, flush=True)

    return tell


def write_index(out: Path) -> None:
    """Write a page with all plates of a folder."""
    with atomic_write(out / "index.html") as temporary:
        temporary.write_text("".join(_index(out)), encoding="utf-8")


def _index(out: Path) -> Iterator[str]:
    yield '<!DOCTYPE html>\n<html lang="en"><meta charset="utf-8"><title>Gallery</title>\n'
    for plate in sorted(out.glob("*/plate.png")):
        name = escape(plate.parent.name)
        yield f'<h2><a href="{name}/compare.html">{name}</a></h2>\n'
        yield f'<img src="{name}/plate.png" alt="plate of {name}">\n'


def draw_for_docs(folder: Path, processes: int) -> None:
    """Draw the pictures of the documentation, all of the sample that may be shipped."""
    scene = load_sample("motorcycle")
    best, paper = geohue.segment(scene), geohue.segment(scene, preset="paper")
    assert best.levels is not None
    shown = {"the scene": scene.colors}
    shown[f"best, the default: {best.k} segments"] = overlay(scene.colors, best.labels)
    matched = match_labels(paper.labels, best.labels)
    shown[f"paper: {paper.k} segments"] = overlay(scene.colors, matched)
    write_jpeg(folder / "motorcycle.jpg", panels(shown, 500, 3))
    write_jpeg(folder / "motorcycle-levels.jpg", panels(_levels(scene, best.levels), 600, 2))
    done = compare(scene, k=_K["motorcycle"], processes=processes, progress=_tell("motorcycle"))
    write_jpeg(folder / "plate-motorcycle.jpg", draw_plate(scene, done, size=280))


def _levels(scene: Scene, levels: Levels) -> dict[str, Image]:
    """Show three levels in matching colours, and the borders of all."""
    middle, shown = levels.at("auto"), dict[str, Image]()
    names: tuple[Literal["coarse", "auto", "fine"], ...] = ("coarse", "auto", "fine")
    for detail in names:
        labels = match_labels(levels.at(detail), middle)
        shown[f"{detail}: {levels.count(detail)} segments"] = overlay(scene.colors, labels)
    return shown | {"borders of all levels": paint_borders(scene.colors, levels)}


def panels(shown: Mapping[str, Image], size: int, columns: int) -> Image:
    """Put pictures of one shape in rows, each with its name below."""
    from PIL import Image as Picture
    from PIL import ImageDraw, ImageFont

    tiles = {name: scaled(image, size) for name, image in shown.items()}
    height, width = next(iter(tiles.values())).shape[:2]
    font, step, rows = (
        ImageFont.load_default(size // 26),
        height + size // 14,
        -len(tiles) // columns,
    )
    sheet = Picture.new("RGB", (columns * (width + 6) - 6, -rows * step), (255, 255, 255))
    for place, (name, tile) in enumerate(tiles.items()):
        corner = place % columns * (width + 6), place // columns * step
        sheet.paste(Picture.fromarray(tile), corner)
        below = corner[0] + 4, corner[1] + height + 2
        ImageDraw.Draw(sheet).text(below, name, (25, 25, 25), font)
    return np.asarray(sheet, np.uint8)


def write_jpeg(path: Path, image: Image) -> None:
    """Write a picture as a JPEG of modest size."""
    import cv2

    for quality in (88, 80, 70, 60):
        _, data = cv2.imencode(
            ".jpg", np.ascontiguousarray(image[..., ::-1]), [cv2.IMWRITE_JPEG_QUALITY, quality]
        )
        if len(data) <= _JPEG_LIMIT:
            break
    with atomic_write(path) as temporary:
        temporary.write_bytes(data.tobytes())


def main() -> None:
    """Draw the gallery."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path)
    parser.add_argument("--docs", type=Path)
    parser.add_argument("--scenes", help="names with commas between; by default all")
    parser.add_argument("--frames", type=int, default=3, help="of each folder of frames")
    parser.add_argument("-k", type=int, help="in place of each scene's own K")
    parser.add_argument("--methods", default=",".join(all_rows()))
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    if given.docs is not None:
        draw_for_docs(given.docs, given.processes)
    if given.out is None:
        return
    data = Path(os.environ.get("GEOHUE_DATA", _ROOT.parent / "shared" / "data"))
    wanted = None if given.scenes is None else set(given.scenes.split(","))
    for entry in entries(data, given.frames):
        if wanted is None or entry.name in wanted:
            chosen = entry if given.k is None else replace(entry, k=given.k)
            draw(chosen, given.out, given.methods.split(","), given.processes)
    write_index(given.out)


if __name__ == "__main__":
    main()
