"""``geohue register``: an unregistered depth map into the view of the colour camera."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import Annotated

import typer

from geohue.cli.console import print_json, warn

_AGREE = "edges agree {:.2f} times as well as by chance"


def register(
    color: Annotated[Path, typer.Argument(metavar="COLOR", help="Colour image.")],
    depth: Annotated[
        Path, typer.Argument(metavar="DEPTH", help="Depth map of the depth camera, unregistered.")
    ],
    calib: Annotated[
        list[Path],
        typer.Option(
            metavar="FILE",
            help="Calibration of both cameras; for ROS three times: depth, colour, transform.",
        ),
    ],
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Where results go.")],
    depth_scale: Annotated[
        str | None,
        typer.Option(metavar="M_PER_UNIT|NAME", help="Unit of the depth map: 0.001, tum, kinect."),
    ] = None,
    camera: Annotated[
        int, typer.Option(help="Which colour camera of the calibration, from 1.")
    ] = 1,
    undistort: Annotated[
        bool, typer.Option("--undistort", help="Also write the picture and depth undistorted.")
    ] = False,
    refine: Annotated[
        bool, typer.Option("--refine", help="Move T by up to 4 cm until the edges agree.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON object.")] = False,
) -> None:
    """Bring an unregistered depth map into the view of the colour camera.

    Writes depth_registered.png (16 bit, millimetres, 0 = none) in the pixels of COLOR, and
    intrinsics.json of the colour camera.
    """
    from geohue.studies.register import register_files

    done = register_files(color, depth, calib, out, depth_scale, camera - 1, undistort, refine)
    warn(done.warnings)
    if as_json:
        print_json(done.summary())
        return
    names = ", ".join(file.name for file in done.files)
    edges = "" if isnan(done.edge_agreement) else f"; {_AGREE.format(done.edge_agreement)}"
    typer.echo(f"{done.covered:.0%} of the picture has depth{edges}")
    typer.echo(f"{out}: {names}")
