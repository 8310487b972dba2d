"""Settings of the merging: the cuts that vote."""

from __future__ import annotations

from dataclasses import dataclass

from geohue.errors import GeohueError
from geohue.settings.checks import check_whole
from geohue.settings.consensus import BALANCES, check_voters

COUNTS = (2, 3, 4, 5, 6, 7, 8, 10, 12)
"""Numbers of segments of the cuts of each weight."""

ONE_CUE = tuple(range(2, 47))
"""Those where colour or geometry takes part alone: as many cuts vote, all of one weight."""


@dataclass(frozen=True, slots=True)
class MergeSettings:
    """Who votes on which regions belong together.

    Attributes
    ----------
    panel : tuple of float and str
        Weights and names, as the voters of `ConsensusSettings`; where one cue takes part alone
        its weight votes instead.
    counts : tuple of int
        Numbers of segments of the cuts of each weight.
    counts_alone : tuple of int
        The same where one cue takes part alone.

    Raises
    ------
    GeohueError
        Without a voter or a number, or for a value out of range.

    Examples
    --------
    >>> MergeSettings(counts=(4, 8)).most("fusion")
    8
    """

    panel: tuple[float | str, ...] = BALANCES
    counts: tuple[int, ...] = COUNTS
    counts_alone: tuple[int, ...] = ONE_CUE

    def __post_init__(self) -> None:
        check_voters(self.panel, "panel")
        for name in ("counts", "counts_alone"):
            counts = getattr(self, name)
            if not (isinstance(counts, tuple) and counts):
                raise GeohueError(f"{name} is {counts!r}: expected a tuple of whole numbers")
            for count in counts:
                check_whole(f"a number of {name}", count, 2)

    def cut_into(self, cues: str) -> tuple[int, ...]:
        """Return the numbers of segments of the cuts that vote."""
        return self.counts_alone if cues in ("color", "geometry") else self.counts

    def most(self, cues: str) -> int:
        """Return the most segments of a cut that votes."""
        return max(self.cut_into(cues))
