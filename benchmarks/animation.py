"""The animation of the README: the simulated sequence beside its segments.

python -m benchmarks.animation docs/images/video.webp [--preset best]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

from geohue import Intrinsics, VideoSegmenter
from geohue.results.picture import overlay
from geohue.simulate.moving import moving_scene

CAMERA = Intrinsics(262.5, 262.5, 159.5, 119.5, 320, 240)


def main() -> None:
    """Write every other frame of 90 as an animated WebP."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", type=Path)
    parser.add_argument("--preset", default="best")
    given = parser.parse_args()
    pictures = []
    with VideoSegmenter(given.preset) as video:
        for i, frame in enumerate(moving_scene(90, CAMERA, "kinect")):
            labels = video.update(frame.scene, frame.pose).labels
            if i % 2 == 0:
                both = np.hstack([frame.scene.colors, overlay(frame.scene.colors, labels)])
                pictures.append(Image.fromarray(both))
    first, *others = pictures
    first.save(
        given.path,
        save_all=True,
        append_images=others,
        duration=80,
        loop=0,
        quality=45,
        method=6,
    )


if __name__ == "__main__":
    main()
