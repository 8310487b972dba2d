"""The settings: what is refused when they are made, and how one of them is changed."""

from __future__ import annotations

import math
from dataclasses import asdict, fields
from typing import Any

import pytest

from geohue import PRESETS, GeohueError, Preset, segment
from geohue.scene import Scene
from geohue.settings import (
    ConsensusSettings,
    CutSettings,
    FillSettings,
    MergeSettings,
    WeightSettings,
    preset_named,
)

BAD: dict[str, tuple[Any, ...]] = {
    "draft_points": (0, -5, 2.5, True, "many"),
    "min_region": (-0.1, 1.1, math.nan, None),
    "landmarks": (-1, 0, 1.5, True, "100"),
    "landmark_choice": ("nearest", None),
    "scale": (0, -0.4, math.inf, math.nan, "wide", True),
    "labelling": ("means",),
    "restarts": (-1, 0.5),
    "center_points": (0,),
    "selector": ("gap",),
    "k_max": (1, 0, -3),
    "fit": ("some",),
    "weight_rule": ("best",),
    "weights": ((), (1.0, 1.0), (2.0, 1.0), (0.0, 1.0), (1.0, math.inf), [1.0], 1.0),
    "refinements": ((0.0,), (-0.5,), [0.5]),
    "compared": ((), (4.0, 1.0)),
    "voters": ((), (-1.0,), (math.nan,), [0.0], (None,)),
    "least": (-0.1, 1.5, "few"),
    "clear": (-0.1, math.nan),
    "smallest": ((10,), (0, 30), (10, 2.5), 10),
    "panel": ((), (-1.0,), [0.0]),
    "counts": ((), (1,), (4, 2.5), [4]),
    "counts_alone": ((), (0,), 7),
    "fill_rule": ("flood",),
}


@pytest.mark.parametrize(("name", "value"), [(n, v) for n, values in BAD.items() for v in values])
def test_a_setting_out_of_range_is_named(name: str, value: Any) -> None:
    with pytest.raises(
        GeohueError, match=name.removesuffix("s").replace("_rule", " rule")
    ) as error:
        Preset().changed(**{name: value})
    assert "\n" not in str(error.value)


GOOD: dict[str, tuple[Any, ...]] = {
    "draft_points": (1,),
    "min_region": (0, 0.0, 1.0),
    "landmarks": (1,),
    "scale": (1,),
    "restarts": (0,),
    "k_max": (2,),
    "weights": ((1.0,), (0.5, 2)),
    "refinements": ((), (0.5, 0.5)),
    "voters": ((0, math.inf), ("kmeans",), (1.0, "mine")),
    "least": (0, 1),
    "clear": (0,),
    "smallest": ((1, 1),),
    "panel": ((0, "kmeans"),),
    "counts": ((2,), (12, 3)),
}


@pytest.mark.parametrize(("name", "value"), [(n, v) for n, values in GOOD.items() for v in values])
def test_the_last_values_that_are_taken(name: str, value: Any) -> None:
    changed = Preset().changed(**{name: value})
    found = {**{k: v for k, v in asdict(changed).items() if not isinstance(v, dict)}}
    for stage in ("cut", "weight", "consensus", "merge", "fill"):
        found |= asdict(changed)[stage]
    assert found[name] == value


def test_every_setting_is_tried_above() -> None:
    stages: dict[str, type] = {
        "cut": CutSettings,
        "weight": WeightSettings,
        "consensus": ConsensusSettings,
        "merge": MergeSettings,
    }
    names = {entry.name for kind in stages.values() for entry in fields(kind)} - {"rule"}
    names |= {entry.name for entry in fields(Preset)} - {*stages, "fill"}
    assert names | {"weight_rule", "fill_rule"} == set(BAD)


def test_one_change_leaves_the_rest_as_it_is() -> None:
    fast = PRESETS["fast"]
    changed = fast.changed(landmarks=70, fill_rule="appendix", min_region=0.01)
    assert (changed.cut.landmarks, changed.fill.rule, changed.min_region) == (70, "appendix", 0.01)
    assert changed.changed(landmarks=64, fill_rule="watershed", min_region=0.002) == fast
    assert fast.changed() == fast


def test_a_stage_can_be_changed_whole() -> None:
    changed = Preset().changed(cut=CutSettings(landmarks=7), restarts=9)
    assert changed.cut == CutSettings(landmarks=7, restarts=9)
    with pytest.raises(GeohueError, match=r"fill is 'watershed': expected FillSettings\(...\)"):
        Preset(fill="watershed")  # type: ignore[arg-type]
    assert Preset(fill=FillSettings("watershed")).fill.rule == "watershed"


def test_an_unknown_setting_is_refused_with_the_known_ones() -> None:
    with pytest.raises(GeohueError, match=r"setting 'landmark': .*\blandmarks\b.*\bweight_rule\b"):
        Preset().changed(landmark=3)


def test_the_named_sets() -> None:
    """What docs/method.md says of them; another value changes the labels of every user."""
    paper, fast, best = (preset_named(name) for name in ("paper", "fast", "best"))
    assert paper == Preset()
    cut = paper.cut
    assert (paper.draft_points, cut.landmarks, cut.scale, cut.k_max) == (20_000, 100, 0.4, 10)
    assert (cut.restarts, cut.center_points, paper.min_region) == (4, 5_000, 0.002)
    assert paper.weight.weights == tuple(2.0**e for e in range(-4, 5))
    assert paper.consensus == ConsensusSettings((0.0, 1.0, math.inf), 0.15, 0.6, (10, 30))
    assert (fast.draft_points, fast.cut.landmarks, fast.cut.fit) == (6_000, 64, "draft")
    assert (paper.fill.rule, fast.fill.rule, best.fill.rule) == ("appendix", *["watershed"] * 2)
    assert (best.draft_points, best.cut.landmarks, best.cut.fit) == (20_000, 128, "all")
    assert (paper.weight.rule, fast.weight.rule, best.weight.rule) == ("quality", *["merge"] * 2)
    assert best.merge == MergeSettings((0.0, 1.0, math.inf), (2, 3, 4, 5, 6, 7, 8, 10, 12))
    assert (fast.merge.counts, best.merge.counts_alone) == ((4, 8, 12), tuple(range(2, 47)))


def test_settings_of_ones_own_reach_the_stages(three_boxes: tuple[Scene, object]) -> None:
    scene, _ = three_boxes
    own = Preset().changed(draft_points=2000, weights=(0.5, 1.0), refinements=())
    assert [weight for weight, _ in segment(scene, 3, preset=own).weight_curve] == [0.5, 1.0]
