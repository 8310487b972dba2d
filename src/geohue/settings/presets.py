"""The settings behind ``preset=``: the paper's method, a faster and a finer one."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, fields, replace
from typing import Any

from geohue.errors import GeohueError
from geohue.plugins import Registry
from geohue.settings.checks import check_share, check_whole
from geohue.settings.consensus import ConsensusSettings
from geohue.settings.cut import CutSettings
from geohue.settings.fill import FillSettings
from geohue.settings.merge import MergeSettings
from geohue.settings.weight import COARSE, WeightSettings


@dataclass(frozen=True, slots=True)
class Preset:
    """Every setting of the method; a user's own is as good as a named one.

    Attributes
    ----------
    draft_points : int
        Points on which K and the weight are chosen.
    min_region : float
        Smaller regions of a grid, as a share of its pixels, join what surrounds them; those of a
        cloud in the consensus.
    cut : CutSettings
        Sec. III: landmarks, affinity, labels, K.
    weight : WeightSettings
        Sec. IV: what chooses the weight.
    consensus : ConsensusSettings
        Who votes, and what a border needs to stay.
    merge : MergeSettings
        Who votes on the regions that are merged.
    fill : FillSettings
        Appendix: pixels without depth.

    Raises
    ------
    GeohueError
        For a value out of range.

    Examples
    --------
    >>> Preset(cut=CutSettings(landmarks=50)) == Preset().changed(landmarks=50)
    True
    """

    draft_points: int = 20_000
    min_region: float = 0.002
    cut: CutSettings = field(default_factory=CutSettings)
    weight: WeightSettings = field(default_factory=WeightSettings)
    consensus: ConsensusSettings = field(default_factory=ConsensusSettings)
    merge: MergeSettings = field(default_factory=MergeSettings)
    fill: FillSettings = field(default_factory=FillSettings)

    def __post_init__(self) -> None:
        check_whole("draft_points", self.draft_points, 1)
        check_share("min_region", self.min_region)
        for name, kind in STAGES.items():
            if not isinstance(getattr(self, name), kind):
                raise GeohueError(
                    f"{name} is {getattr(self, name)!r}: expected {kind.__name__}(...)"
                )

    def changed(self, **changes: Any) -> Preset:
        """Return the preset with some settings changed, in whichever stage they stand.

        Parameters
        ----------
        **changes
            New values by the names of the settings; one that two stages share has the stage's
            name before it (`fill_rule`).

        Returns
        -------
        Preset

        Raises
        ------
        GeohueError
            For an unknown name or a value out of range.

        Examples
        --------
        >>> fine = PRESETS["paper"].changed(landmarks=200, fill_rule="watershed")
        >>> fine.cut.landmarks, fine.fill.rule
        (200, 'watershed')
        """
        own = {name: value for name, value in changes.items() if name in _OWN}
        inner: dict[str, dict[str, Any]] = {}
        for name, value in changes.items():
            if name in _OWN:
                continue
            if name not in _PLACES:
                raise GeohueError(
                    f"setting {name!r}: choose one of {', '.join(sorted(_OWN | _PLACES.keys()))}"
                )
            stage, inside = _PLACES[name]
            inner.setdefault(stage, {})[inside] = value
        for stage, values in inner.items():
            own[stage] = replace(own.get(stage, getattr(self, stage)), **values)
        return replace(self, **own)


PAPER_METHOD = "nncsc"
"""The name of the paper's method, as in ``method=``."""

STAGES: dict[str, type[Any]] = {
    "cut": CutSettings,
    "weight": WeightSettings,
    "consensus": ConsensusSettings,
    "merge": MergeSettings,
    "fill": FillSettings,
}
"""The stages that have settings of their own; a new one is a field of `Preset` and a line here."""

_OWN = {entry.name for entry in fields(Preset)}


def _places() -> dict[str, tuple[str, str]]:
    """Where each setting stands; a name that two stages have gets the stage's before it."""
    inside = [(stage, entry.name) for stage, kind in STAGES.items() for entry in fields(kind)]
    often = Counter(name for _, name in inside)
    return {f"{stage}_{name}" if often[name] > 1 else name: (stage, name) for stage, name in inside}


_PLACES = _places()

_OWN_PRESETS = {
    "paper": Preset(),
    "fast": Preset(
        draft_points=6_000,
        cut=CutSettings(landmarks=64, fit="draft", restarts=2, center_points=2_000),
        weight=WeightSettings(rule="merge", compared=COARSE),
        merge=MergeSettings(counts=(4, 8, 12)),
        fill=FillSettings("watershed"),
    ),
    "best": Preset(
        cut=CutSettings(landmarks=128),
        weight=WeightSettings(rule="merge"),
        fill=FillSettings("watershed"),
    ),
}

PRESETS: Registry[Preset] = Registry(
    "presets", _OWN_PRESETS, lambda value: isinstance(value, Preset), "a Preset"
)
"""The presets by name, those of plugins included."""


def register_preset(name: str, preset: Preset) -> Preset:
    """Let ``preset=`` and `geohue benchmark` take settings by a name.

    Parameters
    ----------
    name : str
        A new name.
    preset : Preset
        The settings.

    Returns
    -------
    Preset
        The settings themselves.

    Raises
    ------
    GeohueError
        For a name that is taken.

    Examples
    --------
    >>> rough = register_preset("rough", PRESETS["fast"].changed(draft_points=2_000))
    >>> preset_named("rough").draft_points
    2000
    >>> PRESETS.remove("rough")
    """
    PRESETS.add(name, preset)
    return preset


def preset_named(preset: str | Preset) -> Preset:
    """Return a preset by its name, or as it is.

    Raises
    ------
    GeohueError
        For an unknown name.

    Examples
    --------
    >>> preset_named("paper").cut.landmark_choice
    'random'
    """
    if isinstance(preset, Preset):
        return preset
    if preset not in PRESETS:
        raise GeohueError(f"preset {preset!r}: choose one of {', '.join(PRESETS)}")
    return PRESETS[preset]
