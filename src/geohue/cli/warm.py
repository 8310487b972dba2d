"""``geohue warm``: compile ahead of the first run."""

from __future__ import annotations

from time import perf_counter

import typer

from geohue.compute.first_run import on_compile


def warm() -> None:
    """Compile every loop now, for example when an image of a machine is built.

    They are kept in the folder named by NUMBA_CACHE_DIR, else beside the code, else in the user's
    cache, and compiled again when the version or the processor changes.
    """
    from geohue.segmentation.warm import compile_all

    begin = perf_counter()
    with on_compile(lambda: typer.echo("geohue: compiling all loops (10 to 20 seconds)", err=True)):
        compile_all()
    typer.echo(f"all loops are compiled ({perf_counter() - begin:.0f} s)")
