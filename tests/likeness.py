"""How alike two labellings are, whatever their labels are called."""

from __future__ import annotations

from typing import Any

import numpy as np

from geohue.measures import adjusted_rand_index


def adjusted_rand_score(one: Any, other: Any) -> float:
    """The adjusted Rand index; tests/measures compares it with scikit-learn's."""
    return adjusted_rand_index(
        np.ravel(one).astype(np.int64), np.ravel(other).astype(np.int64), ignore=None
    )
