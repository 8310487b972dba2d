"""The split of the public frames into those to fit on and those to test on."""

from __future__ import annotations

from pathlib import Path

import pytest

FOLDERS = {"nyuv2": (120, 120), "mosd": (22, 23), "maize": (3, 4), "rooms": (0, 2)}


@pytest.fixture(autouse=True)
def _benchmarks_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_file_is_what_the_rule_gives(folder: str) -> None:
    from benchmarks.splits import part, split

    fit, test = part(folder, "fit"), part(folder, "test")
    assert (len(fit), len(test)) == FOLDERS[folder]
    assert not set(fit) & set(test)
    assert split(folder, fit + test) == {"fit": fit, "test": test}


def test_no_room_is_in_both_parts() -> None:
    from benchmarks.splits import part

    fit, test = (sorted(map(int, part("nyuv2", name))) for name in ("fit", "test"))
    assert min(abs(a - b) for a in fit for b in test) > 3
    # The labels of parts and of objects are those of one room.
    assert len({name.split("_")[0] for name in part("rooms", "test")}) == 1


def test_kinds_are_halved() -> None:
    from benchmarks.splits import part

    fit = [int(name.removeprefix("learn")) for name in part("mosd", "fit")]
    kinds = [(0, 17), (17, 25), (25, 33), (33, 45)]
    assert [sum(low <= n < high for n in fit) for low, high in kinds] == [8, 4, 4, 6]


def test_part_of_a_name() -> None:
    from benchmarks.splits import is_in, part

    name = part("maize", "fit")[0]
    assert is_in("maize", name, "fit")
    assert not is_in("maize", name, "test")
    with pytest.raises(KeyError, match="plant99"):
        is_in("maize", "plant99", "fit")


def test_all_named_frames_are_there(data_dir: Path) -> None:
    from benchmarks.splits import part

    for folder in ("nyuv2", "mosd"):
        if (data_dir / folder / "frames").is_dir():
            there = {path.name for path in (data_dir / folder / "frames").iterdir()}
            assert there >= {*part(folder, "fit"), *part(folder, "test")}
