"""RealSense cameras, through Intel's own package (Apache 2.0; extra ``realsense``)."""

from __future__ import annotations

import numpy as np

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.read.extras import optional
from geohue.scene import Scene
from geohue.video.sources import Shot

NAME = "realsense"
"""What a sequence is called on the command line that comes from such a camera."""


class RealSenseCamera:
    """Colour and depth of a RealSense, the depth in the view of the colour camera.

    Parameters
    ----------
    serial : str, optional
        Of the device; by default the first one.
    width, height, rate : int
        Of both streams.

    Raises
    ------
    GeohueError
        If pyrealsense2 is not installed or the device does not start.
    """

    def __init__(
        self, serial: str | None = None, width: int = 640, height: int = 480, rate: int = 30
    ) -> None:
        rs = optional("pyrealsense2", "realsense", NAME)
        config = rs.config()
        if serial:
            config.enable_device(serial)
        config.enable_stream(rs.stream.color, width, height, rs.format.rgb8, rate)
        config.enable_stream(rs.stream.depth, width, height, rs.format.z16, rate)
        self._pipeline, self._align = rs.pipeline(), rs.align(rs.stream.color)
        try:
            profile = self._pipeline.start(config)
        except RuntimeError as error:
            raise GeohueError(f"{NAME}: {error}; check that the camera is plugged in") from error
        self._unit = float(profile.get_device().first_depth_sensor().get_depth_scale())
        lens = profile.get_stream(rs.stream.color).as_video_stream_profile().get_intrinsics()
        self._lens = Intrinsics(lens.fx, lens.fy, lens.ppx, lens.ppy, lens.width, lens.height)
        self._next = 0

    def read(self) -> Shot:
        """Return the next frame; one that does not come has no scene but a reason."""
        number, self._next = self._next, self._next + 1
        name = f"frame-{number:06d}"
        try:
            frames = self._align.process(self._pipeline.wait_for_frames())
            color = np.asanyarray(frames.get_color_frame().get_data()).copy()
            depth = np.asanyarray(frames.get_depth_frame().get_data()).copy()
        except RuntimeError as error:
            return Shot(number, name, None, None, str(error))
        return Shot(number, name, Scene.from_rgbd(color, depth, self._lens, self._unit))

    def close(self) -> None:
        """Stop the streams."""
        self._pipeline.stop()
