"""Beyond the paper: cuts by colour, by geometry and by both vote on every border.

Sec. IV looks for the one weight whose cut is best, and Sec. III for one number of segments. Here
the cuts of several weights into several numbers of segments are made, and a border stays where
enough of them draw it and something changes across it. What one cut splits at random, the others
do not split in the same place, or nothing is to be seen there.
"""

from geohue.consensus.contrast import join_faint
from geohue.consensus.cut import Consensus, find_consensus
from geohue.consensus.spread import spread
from geohue.consensus.voters import (
    CutVoter,
    Voter,
    known_voters,
    make_voters,
    register_voter,
    remove_voter,
)
from geohue.consensus.votes import count_votes, join_by_votes

__all__ = [
    "Consensus",
    "CutVoter",
    "Voter",
    "count_votes",
    "find_consensus",
    "join_by_votes",
    "join_faint",
    "known_voters",
    "make_voters",
    "register_voter",
    "remove_voter",
    "spread",
]
