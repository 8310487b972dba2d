"""The settings of every stage, checked when they are made, and the named sets of them."""

from geohue.settings.consensus import ConsensusSettings
from geohue.settings.cut import CutSettings
from geohue.settings.fill import FillSettings
from geohue.settings.merge import MergeSettings
from geohue.settings.presets import PAPER_METHOD, PRESETS, Preset, preset_named, register_preset
from geohue.settings.weight import WeightSettings

__all__ = [
    "PAPER_METHOD",
    "PRESETS",
    "ConsensusSettings",
    "CutSettings",
    "FillSettings",
    "MergeSettings",
    "Preset",
    "WeightSettings",
    "preset_named",
    "register_preset",
]
