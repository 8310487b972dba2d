"""Labels for the pixels without depth, spread from the labelled ones by colour (Appendix).

The paper's five steps assign one pixel at a time, the globally cheapest, and every assignment
changes the medians around it. Here a heap holds each unlabelled pixel of the border once, and
each labelled pixel of the border keeps the colours of its window sorted: an assignment inserts one
colour into the few windows that see it, and the costs that rest on a changed median move up or
down in the heap. The order is the paper's, step by step, never a stale one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import check_labels
from geohue.errors import GeohueError
from geohue.fill import state


def _check(
    labels: NDArray[np.int32], lab: NDArray[Any], window: int, mask: NDArray[np.bool_] | None
) -> NDArray[np.float32]:
    if lab.shape != (*labels.shape, 3):
        raise GeohueError(
            f"lab: shape {lab.shape} with labels of shape {labels.shape}; "
            f"expected {(*labels.shape, 3)}"
        )
    if not np.issubdtype(lab.dtype, np.floating):
        raise GeohueError(
            f"lab: {lab.dtype} values; expected float32 CIELab (8-bit Lab is scaled differently)"
        )
    if not np.all(np.isfinite(lab)):
        raise GeohueError("lab: NaN or infinite values; colours must be finite")
    if isinstance(window, bool) or not isinstance(window, (int, np.integer)):
        raise GeohueError(f"window: {window!r}; expected an odd whole number of pixels")
    if window < 1 or window % 2 == 0:
        raise GeohueError(f"window: {window}; expected an odd number of pixels, 1 or more")
    if mask is not None and (mask.dtype != np.bool_ or mask.shape != labels.shape):
        raise GeohueError(
            f"mask: {mask.dtype} of shape {mask.shape}; expected bool of shape {labels.shape}"
        )
    return lab.astype(np.float32, copy=False)


def fill_labels(
    labels: NDArray[np.integer[Any]],
    lab: NDArray[np.floating[Any]],
    window: int = 7,
    mask: NDArray[np.bool_] | None = None,
) -> NDArray[np.int32]:
    """Spread labels to unlabelled pixels, one at a time, the cheapest first (Appendix).

    The cost of giving the unlabelled pixel p_i the label of its labelled 4-neighbour p_n is the
    sum over L, a and b of ``|lab(p_i) - median|``, the median over the pixels with the label of
    p_n in the window centred on p_n (clipped at the edge of the image; the median of an even
    number of values is the mean of the two in the middle). Of all such pairs the one with the
    lowest cost is assigned, the pixel counts in the medians from then on, and so on until no
    unlabelled pixel has a labelled neighbour. Equal costs: the lowest flat pixel index first, then
    the lowest label.

    Parameters
    ----------
    labels : (H, W) integer array
        Labels, -1 = none.
    lab : (H, W, 3) float32 array
        CIELab colours, all finite.
    window : int, default 7
        Side of W^n in pixels, odd. The paper gives no size.
    mask : (H, W) bool array, optional
        The pixels to be filled; None means all. Unlabelled pixels outside stay -1 and block the
        way. Labelled pixels keep and spread their labels wherever they are.

    Returns
    -------
    (H, W) int32 array
        The filled labels, a new array. Pixels that no labelled pixel reaches through unlabelled
        4-neighbours of the mask are still -1: ``(filled < 0) & mask`` are those.

    Raises
    ------
    GeohueError
        If a shape or type is wrong, a label is below -1, a colour is not finite, or the window is
        even or not positive.

    Notes
    -----
    The differences are absolute: as printed, without the bars, the minimum would take the most
    negative one. Costs are summed in float64 in the order L, a, b. Memory is about 45 bytes per
    pixel, and 12 bytes times window^2 per labelled pixel on the border. The first call of a
    process compiles the loops or loads them from the cache on disk.

    References
    ----------
    Dal Mutto, Zanuttigh, Cortelazzo, "Fusion of geometry and color information for scene
    segmentation", IEEE J. Sel. Topics Signal Process. 6(5), 2012, Appendix.

    Examples
    --------
    A row between a dark and a bright segment; the middle is closer to the bright one:

    >>> import numpy as np
    >>> lab = np.zeros((1, 5, 3), dtype=np.float32)
    >>> lab[0, :, 0] = [10, 12, 60, 88, 90]
    >>> fill_labels(np.array([[0, -1, -1, -1, 1]]), lab).tolist()
    [[0, 0, 1, 1, 1]]
    """
    from geohue.fill.steps import spread, start  # compiled code takes a moment to load

    checked = check_labels(labels, ndim=2)
    colours = _check(checked, lab, window, mask)
    h, w = checked.shape
    image = state.padded(checked, colours, mask, window)
    border = state.empty_border(image)
    windows = state.empty_windows(image)
    start(image, border, windows)
    while spread(image, border, windows):
        windows = state.grown(windows)
    margin = (image.stride - w) // 2
    filled = image.labels.reshape(h + 2 * margin, -1)[margin : margin + h, margin : margin + w]
    return np.maximum(filled, state.OPEN).astype(np.int32, copy=False)
