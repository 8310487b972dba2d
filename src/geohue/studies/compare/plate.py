"""The plate: methods down, cues across, the scene on top, as one labelled picture."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geohue.scene import Scene
from geohue.settings import PAPER_METHOD
from geohue.studies.compare.cells import SCORES, Comparison, Result
from geohue.studies.compare.views import Image, cell_views, input_views, reference_of, scaled

if TYPE_CHECKING:
    from PIL.ImageDraw import ImageDraw
    from PIL.ImageFont import FreeTypeFont, ImageFont

TITLES = {
    PAPER_METHOD: f"proposed ({PAPER_METHOD})",
    "best": "default (best)",
    "fast": "default (fast)",
}
"""What a method is called in pictures, if not by its own name."""

_INK, _PAPER, _GAP, _FAILED = (25, 25, 25), (255, 255, 255), (236, 236, 236), (250, 222, 214)


@dataclass(frozen=True, slots=True)
class Layout:
    """Where things are on a plate, in pixels.

    Attributes
    ----------
    width, height : int
        Of a picture.
    rows, columns : int
        Rows and columns of pictures, that of the scene included.
    """

    width: int
    height: int
    rows: int
    columns: int

    @property
    def text(self) -> int:
        """Size of the letters."""
        return max(11, self.width // 22)

    @property
    def margin(self) -> int:
        """Space between pictures."""
        return self.text

    @property
    def caption(self) -> int:
        """Height of the lines below a picture."""
        return round(3.4 * self.text)

    @property
    def side(self) -> int:
        """Width of the methods' names, on the left."""
        return round(9.5 * self.text)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the plate."""
        width = self.side + self.columns * (self.width + self.margin)
        return width, round(2.2 * self.text) + self.rows * self._step

    @property
    def _step(self) -> int:
        return self.height + self.caption

    def corner(self, row: int, column: int) -> tuple[int, int]:
        """Return x and y of the upper left corner of a picture; row 0 is the scene."""
        head = round(0.5 * self.text) if row == 0 else round(2.0 * self.text)
        return self.side + column * (self.width + self.margin), head + row * self._step


def draw_plate(
    scene: Scene,
    comparison: Comparison,
    truth: NDArray[np.integer] | None = None,
    size: int = 320,
) -> Image:
    """Draw a comparison as one picture.

    Parameters
    ----------
    scene : Scene
        What was compared.
    comparison : Comparison
    truth : integer, shape of the scene, optional
        True labels, 0 for none.
    size : int
        Longer side of each picture, pixels.

    Returns
    -------
    (H, W, 3) uint8
        The colour image, the depth map and the ground truth on top; below them a row a method and
        a column a cue. Cells that are not defined or have failed say so.
    """
    inputs = input_views(scene, truth, reference_of(comparison))
    return arrange(inputs, cell_views(scene, comparison), comparison, size)


def arrange(
    inputs: Mapping[str, Image], cells: Mapping[str, Image], comparison: Comparison, size: int = 320
) -> Image:
    """Put the pictures of a comparison (`input_views`, `cell_views`) in their places."""
    from PIL import Image as Picture
    from PIL import ImageDraw

    first = scaled(next(iter(inputs.values())), size)
    layout = plate_layout(comparison, len(inputs), first.shape[1], first.shape[0])
    plate = Picture.new("RGB", layout.size, _PAPER)
    pen = ImageDraw.Draw(plate)
    font = _font(layout.text)
    for column, (name, image) in enumerate(inputs.items()):
        x, y = layout.corner(0, column)
        plate.paste(Picture.fromarray(scaled(image, size)), (x, y))
        pen.text((x, y + layout.height + 3), name, _INK, font)
    for column, cue in enumerate(comparison.cues):
        x, y = layout.corner(1, column)
        pen.text((x, y - round(1.4 * layout.text)), cue, _INK, font)
    for row, method in enumerate(comparison.methods, start=1):
        _, y = layout.corner(row, 0)
        pen.text((round(0.5 * layout.text), y), "\n".join(_name_lines(method)), _INK, font)
        for column, cue in enumerate(comparison.cues):
            result = comparison.at(method, cue)
            x, y = layout.corner(row, column)
            if result.cell.name in cells:
                image = scaled(cells[result.cell.name], size)
                plate.paste(Picture.fromarray(image), (x, y))
                lines = "\n".join(caption(result))
                pen.text((x, y + layout.height + 2), lines, _INK, _font(layout.text - 1))
            else:
                _draw_gap(pen, layout, (x, y), result, font)
    return np.asarray(plate, np.uint8)


def plate_layout(comparison: Comparison, inputs: int, width: int, height: int) -> Layout:
    """Return the layout of a plate with pictures of a size."""
    columns = max(inputs, len(comparison.cues))
    return Layout(width, height, 1 + len(comparison.methods), columns)


def caption(result: Result) -> list[str]:
    """Return the two lines below the picture of a cell.

    Examples
    --------
    >>> from geohue.studies.compare import Cell
    >>> caption(Result(Cell("edison", "color"), "done", k=31, seconds=2.0, weight=0.0))
    ['31 regions, 2.0 s', '']
    """
    first = f"{result.k} region{'s' if result.k != 1 else ''}, {_seconds(result.seconds)}"
    second = []
    if result.cell.cues == "fusion" and result.weight is not None and math.isfinite(result.weight):
        second.append(f"weight {result.weight:.3g}")
    if result.quality is not None:
        second.append(f"Q {result.quality:.3f}")
    known = [name for name in SCORES if name in result.scores]
    second += [f"{SCORES[name]} {result.scores[name]:.2f}" for name in known]
    return [first, ", ".join(second)]


def _seconds(value: float | None) -> str:
    return "? s" if value is None else f"{value:.1f} s"


def _name_lines(method: str) -> list[str]:
    """Break a method's name, which has little room."""
    return TITLES.get(method, method).replace("-", "-\n").replace(" (", "\n(").split("\n")


def _draw_gap(
    pen: ImageDraw,
    layout: Layout,
    corner: tuple[int, int],
    result: Result,
    font: FreeTypeFont | ImageFont,
) -> None:
    """Draw a cell without a picture, with the reason."""
    x, y = corner
    failed = result.status == "failed"
    box = (x, y, x + layout.width - 1, y + layout.height - 1)
    pen.rectangle(box, fill=_FAILED if failed else _GAP)
    letters = int(layout.width / (0.58 * layout.text))
    lines = _wrapped(f"failed: {result.reason}" if failed else "not defined", letters)
    room = max(1, int(layout.height / (1.3 * layout.text)) - 1)
    if len(lines) > room:
        lines = [*lines[: room - 1], "..."]
    pen.text((x + layout.margin // 2, y + layout.margin // 2), "\n".join(lines), _INK, font)


def _wrapped(text: str, width: int) -> list[str]:
    from textwrap import wrap

    return wrap(text, max(8, width))


def _font(size: int) -> FreeTypeFont | ImageFont:
    from PIL import ImageFont

    return ImageFont.load_default(size)
