"""A folder of label images against a folder of reference labels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geohue.errors import GeohueError
from geohue.measures import evaluate
from geohue.measures.crop import Crop
from geohue.measures.object_report import ObjectProtocol
from geohue.read.files import broken

_NAMES = ("labels_object.png", "labels.png", "labels.npy")


def label_files(folder: str | Path) -> dict[str, Path]:
    """Find the label images of a folder by the names of their frames.

    Parameters
    ----------
    folder : str or Path
        With ``NAME.png`` for each frame, or a folder ``NAME`` for each frame with
        ``labels_object.png``, ``labels.png`` or ``labels.npy`` in it.

    Returns
    -------
    dict of str to Path
        In the order of the names.

    Raises
    ------
    GeohueError
        If there are none.
    """
    found = {path.stem: path for path in Path(folder).glob("*.png")}
    for part in Path(folder).iterdir():
        inside = [part / name for name in _NAMES if (part / name).is_file()]
        if inside:
            found[part.name] = inside[0]
    if not found:
        raise broken(folder, "has no label images; give NAME.png or NAME/labels.png each frame")
    return dict(sorted(found.items()))


def evaluate_folders(
    pred: str | Path,
    gt: str | Path,
    crop: Crop | None = None,
    objects: ObjectProtocol | None = None,
) -> dict[str, Any]:
    """Measure the label images of a folder against those of the same names in another one.

    Parameters
    ----------
    pred, gt : str or Path
        Folders of label images (`label_files`, `read_segments`).
    crop : (top, bottom, left, right), optional
        Compare this part only.
    objects : ObjectProtocol, optional
        Measure objects, too.

    Returns
    -------
    dict
        ``mean``: the mean of each measure; ``frames``: all measures by the name of the frame;
        ``missing``: the names that only the reference has.

    Raises
    ------
    GeohueError
        If a prediction has no reference, a file cannot be read, or the sizes of a pair differ.
    """
    from geohue.read.labels import read_segments

    predictions, references = label_files(pred), label_files(gt)
    unknown = [name for name in predictions if name not in references]
    if unknown:
        raise GeohueError(
            f"{pred}: {len(unknown)} frame(s) such as {unknown[0]} are not in {gt}; "
            "name both folders' frames alike"
        )
    frames: dict[str, dict[str, float]] = {}
    for name, path in predictions.items():
        try:
            truth = read_segments(references[name]) + 1
            frames[name] = evaluate(read_segments(path), truth, crop=crop, objects=objects)
        except GeohueError as error:
            raise GeohueError(f"frame {name}: {error}") from error
    measures = next(iter(frames.values()))
    mean = {m: sum(scores[m] for scores in frames.values()) / len(frames) for m in measures}
    missing = [name for name in references if name not in frames]
    return {"mean": mean, "frames": frames, "missing": missing}
