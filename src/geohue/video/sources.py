"""Where frames come from: recordings on disk, a colour video with depth maps, a camera."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import Frame, sorted_files
from geohue.errors import GeohueError
from geohue.read.files import broken, reason
from geohue.scene import Scene

DEPTH_FILES = ("*.png", "*.tif", "*.tiff", "*.npy", "*.npz", "*.pfm", "*.exr")
"""Which files of a folder are depth maps."""

VIDEO_FILES = (".mp4", ".webm", ".mkv", ".avi", ".mov", ".m4v")
"""Endings of colour videos."""


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """What a camera gives at a moment.

    Attributes
    ----------
    number : int
        Counted from 0, of damaged and missing frames too.
    name : str
        Unique in the sequence.
    scene : Scene or None
        None for a frame that cannot be read.
    pose : (4, 4) float64 or None
        Camera to world.
    error : str
        Why there is no scene.
    """

    number: int
    name: str
    scene: Scene | None
    pose: NDArray[np.float64] | None = None
    error: str = ""


class Camera(Protocol):
    """What frames are read from, one after the other."""

    def read(self) -> Shot | None:
        """Return the next frame, None at the end."""

    def close(self) -> None:
        """Let the device or file go."""


class FileCamera:
    """A recording as a camera.

    Parameters
    ----------
    frames : sequence of Frame
        For example a `geohue.datasets.Dataset`.
    start : int
        Number of the first frame to read.
    stop : int, optional
        Number of the first frame not to read.

    Examples
    --------
    >>> import numpy as np
    >>> from geohue.datasets import Frame
    >>> black = Frame("a", lambda: np.zeros((4, 6, 3), np.uint8), lambda: np.ones((4, 6), "f4"))
    >>> camera = FileCamera([black])
    >>> camera.read().scene.shape, camera.read()
    ((4, 6), None)
    """

    def __init__(
        self, frames: list[Frame] | tuple[Frame, ...], start: int = 0, stop: int | None = None
    ) -> None:
        self._frames, self._next = frames, start
        self._stop = len(frames) if stop is None else min(stop, len(frames))

    def read(self) -> Shot | None:
        """Return the next frame, None at the end; a damaged one has no scene but a reason."""
        if self._next >= self._stop:
            return None
        number, self._next = self._next, self._next + 1
        frame = self._frames[number]
        try:
            return Shot(number, frame.name, frame.scene(), frame.T_world_camera)
        except (GeohueError, OSError, ValueError) as error:
            return Shot(number, frame.name, None, None, reason(error))

    def close(self) -> None:
        """Nothing is held open."""


class PacedCamera:
    """A camera that gives the frames of another at a steady pace, as a device would.

    Parameters
    ----------
    camera : Camera
    rate : float
        Frames a second, positive.
    """

    def __init__(self, camera: Camera, rate: float) -> None:
        if not (np.isfinite(rate) and rate > 0):
            raise GeohueError(f"rate is {rate}: expected frames a second above 0")
        self._camera, self._step = camera, 1 / rate
        self._due: float | None = None

    def read(self) -> Shot | None:
        """Return the next frame when it is due."""
        now = time.perf_counter()
        due = now if self._due is None else self._due + self._step
        if due > now:
            time.sleep(due - now)
        self._due = max(due, now - self._step)
        return self._camera.read()

    def close(self) -> None:
        """Close the other camera."""
        self._camera.close()


def video_frames(
    video: Path,
    depth: Path,
    intrinsics: Intrinsics | None = None,
    depth_scale: float | str | None = None,
) -> list[Frame]:
    """Pair the pictures of a colour video with the depth maps of a folder, in their order.

    Parameters
    ----------
    video : Path
        A file that OpenCV reads.
    depth : Path
        Folder of depth maps, numbers in their names in order of size.
    intrinsics : Intrinsics, optional
        The camera.
    depth_scale : float or str, optional
        As for `geohue.read.read_depth`.

    Returns
    -------
    list of Frame
        As many as there are of the fewer; the pictures are decoded when asked for, quickly if in
        order.

    Raises
    ------
    GeohueError
        If the video cannot be read or there is no depth map.
    """
    files = sorted_files(depth, *DEPTH_FILES) if depth.is_dir() else []
    if not files:
        raise broken(depth, "is no folder with depth maps (PNG, TIFF, NPY, NPZ, PFM, EXR)")
    pictures = _Pictures(video)
    return [
        Frame(f"{video.stem}-{i:06d}", pictures.getter(i), file, intrinsics, depth_scale)
        for i, file in enumerate(files[: len(pictures)])
    ]


class _Pictures:
    """The pictures of a video by number; going back starts anew."""

    def __init__(self, path: Path) -> None:
        import cv2

        self._path, self._at = path, 0
        if not path.is_file():
            raise broken(path, "no such video; check the name")
        self._reader = cv2.VideoCapture(str(path))
        self._count = int(self._reader.get(cv2.CAP_PROP_FRAME_COUNT))
        if not self._reader.isOpened() or self._count <= 0:
            raise broken(path, "cannot be decoded; convert it to MP4 (H.264) or WebM")

    def __len__(self) -> int:
        return self._count

    def getter(self, number: int) -> Callable[[], NDArray[np.uint8]]:
        """Return what decodes one picture."""
        return lambda: self._decode(number)

    def _decode(self, number: int) -> NDArray[np.uint8]:
        import cv2

        if number < self._at:
            self._reader = cv2.VideoCapture(str(self._path))
            self._at = 0
        picture = np.zeros((1, 1, 3), np.uint8)
        while self._at <= number:
            there, found = self._reader.read()
            self._at += 1
            if not there or found is None:
                raise broken(self._path, f"ends before picture {number}; copy it again")
            picture = np.asarray(found, np.uint8)
        return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)
