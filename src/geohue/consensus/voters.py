"""Who votes in the consensus: normalized cuts of some weights, compared systems, or one's own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from geohue.baselines import BASELINES, Baseline
from geohue.compute.parallel import Workers
from geohue.errors import GeohueError
from geohue.ncut.cutter import Cutter
from geohue.plugins import Registry
from geohue.prepared import PreparedScene

Labels = NDArray[np.int32]


class Voter(Protocol):
    """Something that segments the draft, once or in several ways; each map is a vote."""

    @property
    def weight(self) -> float:
        """The paper's lambda that it goes by, NaN if none."""

    def maps(self, prepared: PreparedScene) -> Sequence[Labels]:
        """Segment the draft.

        Parameters
        ----------
        prepared : PreparedScene
            The scene with its draft. Called from several threads.

        Returns
        -------
        sequence of int32 arrays
            Labels in the shape of ``prepared.draft``, -1 = none; an empty one abstains.
        """


@dataclass(frozen=True, slots=True, eq=False)
class CutVoter:
    """The normalized cuts of one weight into several numbers of segments.

    Attributes
    ----------
    cutter : Cutter
        Makes the cuts; all voters share its landmarks.
    weight : float
        The paper's lambda, 0 to infinity.
    counts : sequence of int
        The numbers of segments.
    """

    cutter: Cutter
    weight: float
    counts: Sequence[int]

    def maps(self, prepared: PreparedScene) -> Sequence[Labels]:  # noqa: ARG002
        """Cut the draft into each number of segments."""
        return self.cutter.draft_cuts(self.weight, self.counts)


@dataclass(frozen=True, slots=True, eq=False)
class BaselineVoter:
    """A compared system: one map for each number of segments, or one if it finds its own.

    Attributes
    ----------
    baseline : Baseline
        The system; it gets colour and geometry alike.
    """

    baseline: Baseline

    @property
    def weight(self) -> float:
        """1 if it goes by the vectors, NaN otherwise."""
        return 1.0 if self.baseline.uses_weight else math.nan

    def maps(self, prepared: PreparedScene) -> Sequence[Labels]:
        """Segment the draft."""
        most = prepared.settings.cut.k_max if self.baseline.uses_k else 2
        features, alone = prepared.draft_features, Workers(None)
        return [
            self.baseline.run(prepared.draft, features, 1.0, k, prepared.seed, alone)
            for k in range(2, most + 1)
        ]


_REGISTERED: Registry[Voter] = Registry(
    "voters", {}, lambda value: callable(getattr(value, "maps", None)), "a Voter"
)


def register_voter(name: str, voter: Voter) -> None:
    """Let `ConsensusSettings.voters` name a voter.

    Parameters
    ----------
    name : str
        A new name.
    voter : Voter
        The voter.

    Raises
    ------
    GeohueError
        For a name that is taken.

    Examples
    --------
    >>> class Halves:
    ...     weight = math.nan
    ...     def maps(self, prepared):
    ...         half = np.arange(prepared.draft.size) * 2 // prepared.draft.size
    ...         return [half.reshape(prepared.draft.shape).astype(np.int32)]
    >>> register_voter("halves", Halves())
    >>> "halves" in known_voters()
    True
    >>> remove_voter("halves")
    """
    if not name or name in known_voters():
        raise GeohueError(f"voter {name!r}: the name is taken or empty")
    _REGISTERED.add(name, voter)


def remove_voter(name: str) -> None:
    """Forget a voter that was registered."""
    _REGISTERED.remove(name)


def known_voters() -> tuple[str, ...]:
    """Return the names that can stand among the voters, beside weights."""
    return (*BASELINES, *_REGISTERED)


def make_voters(
    prepared: PreparedScene,
    cutter: Cutter,
    entries: Sequence[float | str] | None = None,
    counts: Sequence[int] | None = None,
) -> list[Voter]:
    """Return the voters that settings ask for.

    Parameters
    ----------
    prepared : PreparedScene
        The scene.
    cutter : Cutter
        Its cuts.
    entries : sequence of float and str, optional
        Weights of normalized cuts and names of voters; by default those of the consensus.
    counts : sequence of int, optional
        Numbers of segments of the cuts; by default 2 to `k_max`.

    Returns
    -------
    list of Voter

    Raises
    ------
    GeohueError
        For a name that is not known, or a system that is not defined for the scene.
    """
    settings = prepared.settings
    if entries is None:
        entries = settings.consensus.voters
    if counts is None:
        counts = range(2, settings.cut.k_max + 1)
    return [
        _named(entry, prepared) if isinstance(entry, str) else CutVoter(cutter, entry, counts)
        for entry in entries
    ]


def _named(entry: str, prepared: PreparedScene) -> Voter:
    if entry in _REGISTERED:
        return _REGISTERED[entry]
    if entry not in BASELINES:
        raise GeohueError(f"voter {entry!r}: choose a weight or one of {', '.join(known_voters())}")
    baseline = BASELINES[entry]
    if "fusion" not in baseline.cues:
        raise GeohueError(f"voter {entry!r} is not defined for colour and geometry together")
    if baseline.needs_grid and not prepared.scene.is_grid:
        raise GeohueError(f"voter {entry!r} needs a grid of pixels: this scene is a cloud")
    return BaselineVoter(baseline)
