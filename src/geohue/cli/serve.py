"""``geohue serve``: a page to see, turn, tune and correct segmentations."""

from __future__ import annotations

from typing import Annotated

import typer

_MB = 1 << 20


def serve(
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 takes any free one.")] = 8484,
    host: Annotated[
        str,
        typer.Option(
            metavar="ADDRESS",
            help="Where to listen. Anything but this machine itself needs the token that is shown.",
        ),
    ] = "127.0.0.1",
    token: Annotated[
        str,
        typer.Option(help="The token; made up where one is needed.", envvar="GEOHUE_TOKEN"),
    ] = "",
    show: Annotated[bool, typer.Option("--open/--no-open", help="Open the page.")] = True,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Scenes at a time.")] = 1,
    max_upload: Annotated[
        int, typer.Option(min=1, metavar="MB", help="Largest upload of one scene.")
    ] = 256,
    max_points: Annotated[int, typer.Option(min=1, help="Largest cloud.")] = 5_000_000,
    max_pixels: Annotated[int, typer.Option(min=1, help="Largest image.")] = 25_000_000,
    keep: Annotated[
        int, typer.Option(min=1, metavar="MINUTES", help="How long files are kept unused.")
    ] = 60,
) -> None:
    """Open a page on this machine: drop a scene, see its parts, tune and correct them.

    It works without the internet. Files stay in a temporary folder, which is removed at the end.
    """
    from geohue.web.limits import Limits
    from geohue.web.server import serve as run

    limits = Limits(
        upload_bytes=max_upload * _MB,
        points=max_points,
        pixels=max_pixels,
        workers=workers,
        keep_seconds=keep * 60.0,
    )

    def begun(address: str) -> None:
        typer.echo(f"geohue: {address} (stop with Ctrl-C)")
        if show:
            import webbrowser

            webbrowser.open(address)

    run(host, port, limits, token, begun)
