"""Options said once: what a group is on the command line, and that all commands check alike."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from geohue.cli import options
from geohue.cli.app import app, run
from geohue.cli.groups import with_groups
from geohue.errors import GeohueError
from geohue.segmentation.arguments import SegmentArguments
from geohue.settings import PRESETS


@dataclass(frozen=True)
class Size:
    """Two options."""

    width: Annotated[int, typer.Option("--wide", "-w", min=1)]
    height: Annotated[int, typer.Option()] = 2


def test_a_group_is_an_option_a_field() -> None:
    own, seen = typer.Typer(), []

    @with_groups
    def paint(*, name: Annotated[str, typer.Argument()], size: Size, twice: bool = False) -> None:
        """Paint it."""
        seen.append((name, size, twice))

    own.command()(paint)
    told = CliRunner().invoke(own, ["door", "-w", "3", "--twice"])
    assert told.exit_code == 0, told.output
    assert seen == [("door", Size(3, 2), True)]
    assert CliRunner().invoke(own, ["door"]).exit_code == 2  # a field without a default is needed
    assert CliRunner().invoke(own, ["door", "-w", "0"]).exit_code == 2
    assert "Paint it." in CliRunner().invoke(own, ["--help"]).output


@pytest.mark.parametrize(
    ("command", "groups"),
    [
        ("segment", (options.SceneOptions, options.SegmentOptions)),
        ("batch", (options.SegmentOptions,)),
        ("compare", (options.SceneOptions,)),
        ("info", (options.SceneOptions,)),
    ],
)
def test_commands_have_all_options_of_their_groups(command: str, groups: tuple[type, ...]) -> None:
    given = {param.name for param in typer.main.get_command(app).commands[command].params}  # type: ignore[attr-defined]
    for group in groups:
        assert given >= {entry.name for entry in fields(group)}


def test_options_become_arguments() -> None:
    chosen = options.SegmentOptions(k="3", weight="0.5", method="kmeans", seed=4, fill=False)
    assert chosen.arguments() == SegmentArguments(
        k=3, weight=0.5, method="kmeans", seed=4, fill=False
    )
    # Neither can have what the other has not.
    assert {e.name for e in fields(options.SegmentOptions)} == {
        e.name for e in fields(SegmentArguments)
    }
    with pytest.raises(GeohueError, match="-k three: expected"):
        options.SegmentOptions(k="three").arguments()


def test_what_is_given_beside_the_source() -> None:
    assert options.SceneOptions().beside_source() == {}
    given = options.SceneOptions(depth="d.png", views=1, cameras=["a.png"])  # type: ignore[arg-type, list-item]
    assert given.beside_source() == {"DEPTH": "d.png", "views": 1, "camera": ["a.png"]}


def test_no_levels_to_choose_from() -> None:
    rough = PRESETS["paper"].changed(landmarks=50)
    with pytest.raises(GeohueError, match="and this preset has no levels"):
        SegmentArguments(preset=rough, detail=1)
    assert SegmentArguments(preset=rough, weight="merge", detail=1).merges
    assert not SegmentArguments(method="kmeans").merges
    assert SegmentArguments().as_dict()["preset"] == "best"


def test_info_takes_every_kind_of_scene(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["info", "--sample", "boxes", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kind"] == "RGB-D frame"
    assert run(["info"]) == 2
    assert "no scene: give COLOR DEPTH" in capsys.readouterr().err
