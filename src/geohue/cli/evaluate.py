"""``geohue evaluate``: labels against reference labels."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from geohue.cli.console import print_json


def evaluate(
    pred: Annotated[Path, typer.Argument(metavar="PRED", help="labels.png of a segmentation.")],
    gt: Annotated[Path, typer.Argument(metavar="GT", help="labels.png of the reference.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print a JSON object.")] = False,
) -> None:
    """Measure a segmentation against reference labels.

    Both are label images in which 0 means no label; such pixels of the reference are left out.
    """
    from geohue.evaluate import evaluate as measure
    from geohue.io.images import read_labels

    scores = measure(read_labels(pred) - 1, read_labels(gt))
    if as_json:
        print_json(scores)
        return
    for name, value in scores.items():
        typer.echo(f"{name.replace('_', ' '):24} {value:.4g}")
