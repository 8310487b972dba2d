"""Pictures as a video file, with PyAV."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.read.extras import optional
from geohue.read.files import broken, reason

CODECS = {"webm": ("libvpx", "libvpx-vp9"), "mp4": ("libx264", "libopenh264", "mpeg4")}
"""Encoders of each kind of file, the first that the installed PyAV has is taken."""

_OPTIONS = {
    "libvpx": {"deadline": "realtime", "cpu-used": "8", "crf": "12"},
    "libvpx-vp9": {"deadline": "realtime", "cpu-used": "8", "crf": "30"},
    "libx264": {"preset": "veryfast", "crf": "20"},
}
_RATE = 4_000_000


class VideoWriter:
    """Writes pictures to a WebM or MP4 file that plays whenever it is closed.

    All pictures get the size of the first; sides become even.

    Parameters
    ----------
    path : path-like
        Ending in ``.webm`` (VP8) or ``.mp4`` (H.264).
    rate : float
        Frames a second.
    earlier : path-like, optional
        A video of the same kind that was written before: its pictures come first, in WebM
        copied as they are encoded, in MP4 encoded again.
    copied : int
        How many of them.

    Raises
    ------
    GeohueError
        If PyAV is not installed, the ending is another, or the file cannot be written.
    """

    def __init__(
        self,
        path: str | Path,
        rate: float = 30.0,
        earlier: Path | None = None,
        copied: int = 0,
    ) -> None:
        self._path, self._earlier, self._copied = Path(path), earlier, copied
        self._av = optional("av", "video", path)
        kind = self._path.suffix[1:].lower()
        if kind not in CODECS:
            raise broken(path, "is no .webm or .mp4: choose one of them")
        known = self._av.codec.codecs_available
        self._codec = next((name for name in CODECS[kind] if name in known), None)
        if self._codec is None:
            raise broken(path, f"this PyAV has none of the encoders {', '.join(CODECS[kind])}")
        self._rate = Fraction(rate).limit_denominator(1001)
        self._container: Any = None
        self._stream: Any = None
        self._size = (0, 0)
        self.count = 0

    def write(self, picture: NDArray[np.uint8]) -> None:
        """Add a picture, (H, W, 3) uint8."""
        import cv2

        try:
            if self._container is None:
                self._begin(picture)
            if picture.shape[:2] != self._size:
                height, width = self._size
                resized = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
                picture = np.asarray(resized, np.uint8)
            self._add(picture)
        except (self._av.FFmpegError, OSError) as error:
            raise broken(self._path, f"cannot be written ({reason(error)}); free space") from error

    def close(self) -> None:
        """Finish the file; nothing is there if no picture came. Safe to call twice."""
        if self._container is None:
            return
        try:
            self._container.mux(self._stream.encode())
        finally:
            self._container.close()
            self._container = None

    def _begin(self, picture: NDArray[np.uint8]) -> None:
        height, width = (max(n // 2 * 2, 2) for n in picture.shape[:2])
        old: Any = None
        if self._earlier is not None:
            old = self._av.open(str(self._earlier))
            width, height = old.streams.video[0].width, old.streams.video[0].height
        self._size = height, width
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._container = self._av.open(str(self._path), "w")
        options = _OPTIONS.get(str(self._codec), {})
        self._stream = self._container.add_stream(self._codec, rate=self._rate, options=options)
        self._stream.width, self._stream.height = width, height
        self._stream.pix_fmt, self._stream.bit_rate = "yuv420p", _RATE
        self._stream.codec_context.time_base = 1 / self._rate
        if old is not None:
            with old:
                self._copy(old) if self._path.suffix == ".webm" else self._encode_again(old)

    def _copy(self, old: Any) -> None:
        """Copy the pictures of an earlier video without decoding them."""
        whole = [p for p in old.demux(old.streams.video[0]) if p.dts is not None]
        for i, packet in enumerate(whole[: self._copied]):
            packet.stream = self._stream
            packet.pts = packet.dts = i
            packet.duration, packet.time_base = 1, 1 / self._rate
            self._container.mux(packet)
            self.count += 1

    def _encode_again(self, old: Any) -> None:
        """Encode the pictures of an earlier video again: the header of an MP4 is its encoder's."""
        for i, frame in enumerate(old.decode(video=0)):
            if i >= self._copied:
                break
            self._add(frame.to_ndarray(format="rgb24"))

    def _add(self, picture: NDArray[np.uint8]) -> None:
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
        frame.pts, frame.time_base = self.count, 1 / self._rate
        self._container.mux(self._stream.encode(frame))
        self.count += 1
