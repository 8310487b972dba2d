"""Options that say which depth of a frame is used."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_PANEL = "Depth and camera"

Confidence = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="How sure the sensor is of each pixel of DEPTH, higher is surer.",
        rich_help_panel=_PANEL,
    ),
]
Least = Annotated[
    float | None,
    typer.Option(
        metavar="NUMBER",
        help="Least confidence of depth that is used; by default half of the highest.",
        rich_help_panel=_PANEL,
    ),
]
MinDepth = Annotated[
    float | None,
    typer.Option(metavar="METRES", help="Leave out nearer depth.", rich_help_panel=_PANEL),
]
MaxDepth = Annotated[
    float | None,
    typer.Option(metavar="METRES", help="Leave out farther depth.", rich_help_panel=_PANEL),
]
Mask = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Picture of the size of COLOR: where it is black nothing is segmented.",
        rich_help_panel=_PANEL,
    ),
]
