"""Settings of the consensus: who votes, and what a border needs to stay."""

from __future__ import annotations

import math
from dataclasses import dataclass

from geohue.errors import GeohueError
from geohue.settings.checks import check_share, check_whole, is_number

BALANCES: tuple[float, ...] = (0.0, 1.0, math.inf)
"""Colour alone, both alike, geometry alone: the weights whose cuts vote."""

FINER_BALANCES: tuple[float, ...] = (
    0.0,
    math.tan(math.pi / 8),
    1.0,
    math.tan(3 * math.pi / 8),
    math.inf,
)
"""The same with one more between each two; for one view the angles of the mix are even."""

LEAST = 0.15
"""Share of the cuts that must draw a border for it to stay."""

CLEAR = 0.6
"""Share times contrast that it must have (`join_faint`)."""

SMALLEST = 10, 30
"""Pixels of a grid and points of a cloud below which a region joins what is around it, however
small the draft; the neighbourhood of points is the rougher one."""


@dataclass(frozen=True, slots=True)
class ConsensusSettings:
    """What `find_consensus` goes by.

    Attributes
    ----------
    voters : tuple of float and str
        A number from 0 to infinity votes with the normalized cuts of that weight; a name with the
        maps of that voter (`geohue.consensus.register_voter`) or compared system.
    least : float
        Share of the votes with which a border stays.
    clear : float
        Share times contrast with which it stays (`join_faint`).
    smallest : (int, int)
        Pixels of a grid and points of a cloud below which a region joins what is around it.

    Raises
    ------
    GeohueError
        Without a voter, or for a value out of range.

    Examples
    --------
    >>> ConsensusSettings(voters=(0.0, "kmeans")).least
    0.15
    """

    voters: tuple[float | str, ...] = BALANCES
    least: float = LEAST
    clear: float = CLEAR
    smallest: tuple[int, int] = SMALLEST

    def __post_init__(self) -> None:
        check_voters(self.voters)
        check_share("least", self.least)
        if not (is_number(self.clear) and self.clear >= 0):
            raise GeohueError(f"clear is {self.clear!r}: expected a number of at least 0")
        if not (isinstance(self.smallest, tuple) and len(self.smallest) == 2):
            raise GeohueError(f"smallest is {self.smallest!r}: expected two whole numbers")
        for count in self.smallest:
            check_whole("a number of smallest", count, 1)


def check_voters(voters: object, name: str = "voters") -> None:
    """Raise `GeohueError` unless a setting is a tuple of weights and names of voters."""
    if not (isinstance(voters, tuple) and voters):
        raise GeohueError(f"{name} is {voters!r}: expected a tuple of weights and names")
    for voter in voters:
        if not (isinstance(voter, str) or (is_number(voter) and voter >= 0)):
            raise GeohueError(
                f"a voter of {name} is {voter!r}: expected a weight of at least 0, or a name"
            )
