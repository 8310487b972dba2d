"""RGB-D sequences: segments that keep their identity from frame to frame."""
