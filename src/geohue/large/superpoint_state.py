"""What a run over the tiles of a cloud has done so far, kept so that a killed one can go on."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from geohue.errors import GeohueError
from geohue.large.tile_regions import Across, Floats, TileRegions
from geohue.large.tiles import Buckets, Tiles
from geohue.read.files import broken, reason
from geohue.results.atomic import atomic_write

STATE = "tiles"
"""The folder of the state inside that of the results."""

_IDENTITY, _SORTED = "run.json", "sorted.npz"


@dataclass(frozen=True, slots=True, eq=False)
class Sorted:
    """A cloud that lies in tiles.

    Attributes
    ----------
    tiles : Tiles
        The tiles.
    bounds : (T, 2, 3) float64
        The box of the points of each.
    counts : (T,) int64
        How many points each has.
    is_plain : bool
        Whether all points have one colour.
    """

    tiles: Tiles
    bounds: Floats
    counts: np.ndarray[Any, np.dtype[np.int64]]
    is_plain: bool


class TileState:
    """The state of a run in the folder `STATE` of its results.

    Parameters
    ----------
    out : Path
        The folder of the results.
    identity : dict
        All that the superpoints depend on, as it reads back from JSON.
    resume : bool
        Whether to go on with what is there.

    Raises
    ------
    GeohueError
        If what is there is of another run.
    """

    def __init__(self, out: Path, identity: dict[str, Any], resume: bool) -> None:
        self.folder = out / STATE
        file = self.folder / _IDENTITY
        if resume and file.exists():
            try:
                before = json.loads(file.read_text(encoding="utf-8"))
            except ValueError as error:
                raise broken(file, f"is damaged; remove {self.folder} to begin again") from error
            for name, value in identity.items():
                if before.get(name) != value:
                    raise GeohueError(
                        f"{out}: the run there has {name} = {before.get(name)}, this one {value}; "
                        f"give another folder, or remove {self.folder}"
                    )
        else:
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.mkdir(parents=True)
            with atomic_write(file) as temporary:
                temporary.write_text(json.dumps(identity, indent=2) + "\n", encoding="utf-8")
        self.buckets = Buckets(self.folder)

    def sorted(self) -> Sorted | None:
        """Return the tiles, if the cloud was sorted into them."""
        file = self.folder / _SORTED
        if not file.exists():
            return None
        found = self._read(file)
        tiles = Tiles(*(found[name] for name in ("axis", "cut", "child", "low", "high")))
        return Sorted(tiles, found["bounds"], found["counts"], bool(found["is_plain"]))

    def keep_sorted(self, found: Sorted) -> None:
        """Keep that the cloud was sorted."""
        tiles = found.tiles
        with atomic_write(self.folder / _SORTED) as temporary, temporary.open("wb") as file:
            np.savez(
                file,
                axis=tiles.axis,
                cut=tiles.cut,
                child=tiles.child,
                low=tiles.low,
                high=tiles.high,
                bounds=found.bounds,
                counts=found.counts,
                is_plain=found.is_plain,
            )

    def split(self, tile: int) -> TileRegions | None:
        """Return the regions of a tile, if it was split."""
        file = self.folder / f"graph-{tile}.npz"
        if not file.exists():
            return None
        found = self._read(file)
        across = (
            Across(*(found.pop(f"{kind}.{name}") for name in Across._fields))
            for kind in ("pairs", "same")
        )
        pairs, same = across
        return TileRegions(**found, pairs=pairs, same=same)

    def keep_split(
        self, tile: int, found: TileRegions, labels: np.ndarray[Any, np.dtype[np.int32]]
    ) -> None:
        """Keep the regions of a tile: those of its points first, then what says that they are."""
        arrays = found._asdict()
        for kind in ("pairs", "same"):
            across: Across = arrays.pop(kind)
            arrays |= {f"{kind}.{name}": value for name, value in across._asdict().items()}
        with atomic_write(self.buckets.regions(tile)) as temporary:
            temporary.write_bytes(labels.astype(np.int32).tobytes())
        graph = self.folder / f"graph-{tile}.npz"
        with atomic_write(graph) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)

    def fresh_folder(self) -> Path:
        """Return an empty folder for files that are to appear at the end."""
        folder = self.folder / "whole"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        return folder

    def end(self) -> None:
        """Remove the state of a finished run, first what says that there is one."""
        (self.folder / _IDENTITY).unlink()
        shutil.rmtree(self.folder)

    def _read(self, file: Path) -> dict[str, Any]:
        try:
            with file.open("rb") as handle, np.load(handle) as arrays:
                return dict(arrays)
        except (ValueError, KeyError, EOFError, OSError, BadZipFile) as error:
            raise broken(file, f"is damaged ({reason(error)}); remove it and resume") from error
