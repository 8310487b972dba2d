"""A sample of vectors that depends neither on their order nor on the blocks they come in."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_STEP = np.uint64(0x9E3779B97F4A7C15)
_MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))
_KEYS = 8


class Sketch:
    """The distinct vectors of lowest hash among all seen, each with its total weight.

    A hash of the vector's bits and the seed draws the sample: every distinct vector has the same
    chance, and a vector that falls out never comes back, so that the weights are exact. Equal
    vectors are one vector of their common weight.

    Parameters
    ----------
    size : int
        Most vectors to keep.
    seed : int
        Another seed, another sample.

    Examples
    --------
    >>> sketch = Sketch(size=2, seed=0)
    >>> sketch.add(np.array([[1.0], [4.0], [1.0]]), np.ones(3))
    >>> vectors, weights = sketch.sample()
    >>> vectors.tolist(), weights.tolist(), sketch.whole
    ([[1.0], [4.0]], [2.0, 1.0], True)
    """

    def __init__(self, size: int, seed: int) -> None:
        self._size, self._seed = size, np.uint64(seed)
        self._codes = np.empty(0, np.uint64)
        self._weights = np.empty(0)
        self._vectors: NDArray[np.float64] | None = None
        self.whole = True
        """Whether no vector fell out."""

    def add(self, vectors: NDArray[np.float64], weights: NDArray[np.float64]) -> None:
        """Add a block of vectors, (N, D), and as how many each counts, (N,); 0 is left out."""
        vectors = vectors + 0.0  # -0 becomes 0, which has other bits
        codes = _hashes(vectors, self._seed)
        near = weights > 0
        if not self.whole:
            near &= codes <= self._codes[-1]
        if self._vectors is not None:
            vectors = np.concatenate([self._vectors, vectors[near]])
        else:
            vectors = vectors[near]
        codes = np.concatenate([self._codes, codes[near]])
        found, first, slot = np.unique(codes, return_index=True, return_inverse=True)
        total = np.zeros(len(found))
        np.add.at(total, slot, np.concatenate([self._weights, weights[near]]))
        self.whole &= len(found) <= self._size
        self._codes, self._weights = found[: self._size], total[: self._size]
        self._vectors = vectors[first[: self._size]]

    def sample(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the vectors, (M, D) in the order of their first entries, and weights, (M,)."""
        vectors = np.empty((0, 0)) if self._vectors is None else self._vectors
        # A few columns decide nearly always; where they do not, the hash does.
        order = np.lexsort((self._codes, *vectors.T[:_KEYS][::-1]))
        return vectors[order], self._weights[order]


def _hashes(vectors: NDArray[np.float64], seed: np.uint64) -> NDArray[np.uint64]:
    """Mix the bits of each row into one number (the finalizer of splitmix64, column by column)."""
    bits = np.ascontiguousarray(vectors.T).view(np.uint64)
    code = np.full(len(vectors), seed, np.uint64)
    for column in bits:
        code ^= column
        code += _STEP
        code ^= code >> np.uint64(30)
        code *= _MIX[0]
        code ^= code >> np.uint64(27)
        code *= _MIX[1]
        code ^= code >> np.uint64(31)
    return code
