"""The command line over a cloud in pieces, and a cluster's workers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geohue.large.memory as memory
from geohue.cli.app import run
from geohue.large import segment_file, stages
from large.clouds import table, three_blobs


@pytest.fixture
def cloud(tmp_path: Path) -> str:
    """Three balls as rows of numbers."""
    xyz, rgb, _ = three_blobs(3000)
    np.save(tmp_path / "cloud.npy", table(xyz, rgb))
    return str(tmp_path / "cloud.npy")


def test_segment_in_pieces(cloud: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "out")
    options = ["-k", "3", "--lambda", "1", "--memory", "400MB", "-o", out, "--format", "ply"]
    assert run(["segment", cloud, *options]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith("3 segments, weight 1")
    assert "labels.npy" in printed.out
    assert "segmented.ply" in printed.out
    assert "labelling" in printed.err
    assert run(["segment", cloud, *options, "--resume", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["n_points"] == 3000


def test_too_large_for_memory_is_read_in_pieces(
    cloud: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "available_memory", lambda: memory.PARENT + 300_000)
    out = tmp_path / "out"
    options = ["-k", "3", "--lambda", "1", "-o", str(out)]
    assert run(["segment", cloud, *options]) == 0
    assert "3000 points would take" in capsys.readouterr().err
    assert "n_sample" in json.loads((out / "result.json").read_text())
    assert run(["segment", cloud, *options, "--threads", "1"]) == 2
    told = capsys.readouterr().err
    assert "reading in pieces (the cloud does not fit in memory) and --threads do not go" in told
    monkeypatch.setattr(memory, "available_memory", lambda: 10**10)
    assert run(["segment", cloud, *options]) == 0
    assert capsys.readouterr().err == ""
    assert "n_sample" not in json.loads((out / "result.json").read_text())


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--memory", "300MB"], "give at least 380MB"),
        (["--memory", "lots"], "2GB, 500MB"),
        (["--memory", "2GB", "--method", "kmeans"], "leave out --method kmeans"),
        (["--processes", "1", "--components"], "leave out --components"),
        (["--resume", "--right", "b.png"], "--resume and --right do not go together"),
        (["--memory", "2GB", "--threads", "1"], "--memory and --threads do not go together"),
        (["--memory", "2GB", "--depth-scale", "tum"], "leave out --depth-scale"),
        (["--memory", "2GB", "--disparity-scale", "1/256"], "leave out --disparity-scale"),
        (["--memory", "2GB", "--views", "1"], "leave out --views"),
        (["--memory", "2GB", "--frame", "3"], "leave out --frame"),
        (["--memory", "2GB", "--no-fill"], "leave out --no-fill"),
        (["--processes", "2", "--scheduler", "tcp://a:1"], "both say where to work"),
        (["--memory", "2GB", "--json"], "give the folder of the labels with -o"),
        (["--memory", "2GB", "--format", "coco", "-o", "out"], "choose ply"),
    ],
)
def test_mistakes_are_one_line(
    cloud: str,
    options: list[str],
    says: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["segment", cloud, *options]) == 2
    told = capsys.readouterr().err
    assert told.startswith("geohue: error: ")
    assert says in told
    assert told.count("\n") == 1


def test_no_cloud(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["segment", "--memory", "2GB"]) == 2
    assert "no cloud" in capsys.readouterr().err


def test_a_cluster_gives_the_same(
    cloud: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed: Any = pytest.importorskip("distributed", reason="needs geohue[distributed]")
    monkeypatch.setattr(stages, "JOB", 500)
    here = segment_file(cloud, tmp_path / "here", 3, weight=1.0, processes=1)
    with distributed.LocalCluster(
        n_workers=1,
        threads_per_worker=1,
        processes=False,
        protocol="inproc",
        dashboard_address="127.0.0.1:0",
    ) as cluster:
        address = cluster.scheduler_address
        there = segment_file(cloud, tmp_path / "there", 3, weight=1.0, scheduler=address)
    assert there.sizes == here.sizes
    np.testing.assert_array_equal(np.load(there.labels_file), np.load(here.labels_file))


def test_help_names_what_is_used_by_default(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["segment", "--help"]) == 0
    told = " ".join(word for word in capsys.readouterr().out.split() if word.isascii())
    assert "by default geohue-out." in told
    assert "by default one a core." in told
