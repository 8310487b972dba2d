"""The errors and warnings that geohue raises on purpose."""

from __future__ import annotations


class GeohueError(ValueError):
    """Input that geohue cannot use.

    The message names the cause, the place and the mend, and is shown by the command line as one
    line with exit status 2.

    Examples
    --------
    >>> raise GeohueError("depth.png: 3 channels; a depth map has one")
    Traceback (most recent call last):
    geohue.errors.GeohueError: depth.png: 3 channels; a depth map has one
    """


class GeohueWarning(UserWarning):
    """Input that geohue used after a guess or a repair that the user should know of."""


class SceneWarning(GeohueWarning):
    """What a scene has in its `warnings`."""
