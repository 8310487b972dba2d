"""What the server takes and keeps at most."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from geohue.errors import GeohueError


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of a server; each is stated by ``GET /api/about``.

    Attributes
    ----------
    upload_bytes : int
        Of all files of one scene.
    pixels : int
        Of an image, told by its header before it is unpacked.
    points : int
        Of a cloud.
    shown_points : int
        Points of a scene that the page receives; a random part where there are more.
    workers : int
        Scenes at a time, each in a process of its own.
    waiting : int
        Scenes that wait for a worker.
    kept : int
        Scenes whose files are kept; the one that was looked at longest ago goes first.
    keep_seconds : float
        How long files are kept after they were last asked for.
    run_seconds : float
        How long one scene may take.
    memory_bytes : int
        Of a worker, where the system can limit it.

    Raises
    ------
    GeohueError
        If one is not positive.
    """

    upload_bytes: int = 256 << 20
    pixels: int = 25_000_000
    points: int = 5_000_000
    shown_points: int = 2_000_000
    workers: int = 1
    waiting: int = 16
    kept: int = 64
    keep_seconds: float = 3600.0
    run_seconds: float = 600.0
    memory_bytes: int = 6 << 30

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if not value > 0:
                raise GeohueError(f"{name} is {value}: it must be positive")
