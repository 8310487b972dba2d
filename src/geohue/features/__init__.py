"""Sec. II, V: colour and geometry of each point in one vector (eq. 1-5, 19), a cue a file."""

from geohue.features.block import Block, Side
from geohue.features.color import lab_of
from geohue.features.cue import Cue
from geohue.features.features import Features, extract_features
from geohue.features.normalize import FLOOR, SAME_COLOR, SAME_PLACE, normalized
from geohue.features.raw import Raw
from geohue.features.registry import (
    CUES,
    check_cues,
    cue_columns,
    known_cues,
    register_cue,
    remove_cue,
)

__all__ = [
    "CUES",
    "FLOOR",
    "SAME_COLOR",
    "SAME_PLACE",
    "Block",
    "Cue",
    "Features",
    "Raw",
    "Side",
    "check_cues",
    "cue_columns",
    "extract_features",
    "known_cues",
    "lab_of",
    "normalized",
    "register_cue",
    "remove_cue",
]
