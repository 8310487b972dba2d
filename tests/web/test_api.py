"""The JSON API of a running server."""

from __future__ import annotations

import io
import json
import os
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from struct import pack
from typing import Any

import httpx
import numpy as np
import pytest

import geohue
from geohue import Scene
from geohue.read.clouds.cloud import read_cloud
from geohue.read.images.pictures import read_labels
from geohue.results.png import write_png
from geohue.segmentation.stages import STAGES
from web.client import Client


@pytest.fixture(scope="module")
def done(client: Client, frame: Path) -> str:
    """The name of a job of the frame that is done."""
    ended = client.run({"color": frame / "color.png", "depth": frame / "depth.png"})
    assert ended["state"] == "done", ended
    return str(ended["id"])


@pytest.fixture(scope="module")
def expected(frame_scene: Scene) -> geohue.Segmentation:
    return geohue.segment(frame_scene)


def _without_times(summary: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in summary.items() if key not in ("timings_s", "warnings")}


def test_result_is_the_document_of_the_command_line(
    client: Client, done: str, expected: geohue.Segmentation
) -> None:
    found = client.get(done, "result").json()
    assert _without_times(found) == _without_times(json.loads(json.dumps(expected.summary())))


def test_labels_are_those_of_the_library(
    client: Client, done: str, expected: geohue.Segmentation, tmp_path: Path
) -> None:
    (tmp_path / "labels.png").write_bytes(client.get(done, "export/labels").content)
    assert (read_labels(tmp_path / "labels.png") - 1 == expected.labels).all()


def test_exports_can_be_read(
    client: Client, done: str, expected: geohue.Segmentation, tmp_path: Path
) -> None:
    pytest.importorskip("laspy")
    for name in ("ply", "las"):
        file = tmp_path / f"segmented.{name}"
        file.write_bytes(client.get(done, f"export/{name}").content)
        assert read_cloud(file).points.shape == (expected.n_points, 3)
    assert len(client.get(done, "export/coco").json()["annotations"]) == expected.k
    table = client.get(done, "export/json").json()
    assert [row["size"] for row in table["segments"]] == np.bincount(
        expected.labels.ravel()
    ).tolist()
    array = np.load(io.BytesIO(client.get(done, "export/npy").content))
    assert (array == expected.labels).all()
    report = client.get(done, "export/report")
    assert f"{expected.k} segments" in report.text
    assert "attachment" in report.headers["content-disposition"]


def test_corrections_are_applied(client: Client, done: str) -> None:
    view = client.get(done, "data/view").json()
    body = {"segment_of": [0] * view["n_regions"], "names": {"0": "all <of> it"}}
    rows = client.http.post(f"/api/jobs/{done}/export/json", json=body).json()["segments"]
    assert [(row["name"], row["size"]) for row in rows] == [("all <of> it", sum(view["size"]))]
    report = client.http.post(f"/api/jobs/{done}/export/report", json=body).text
    assert "all &lt;of&gt; it" in report


@pytest.mark.parametrize(
    "body",
    [
        [],
        {"segment_of": [0]},
        {"segment_of": "all"},
        {"names": {"x": "y"}},
        {"names": {"0": "y" * 81}},
        {"more": 1},
    ],
)
def test_corrections_that_do_not_fit_are_refused(client: Client, done: str, body: object) -> None:
    answer = client.http.post(f"/api/jobs/{done}/export/json", json=body)
    assert answer.status_code == 422
    assert answer.json()["error"]


def test_progress_names_the_stages(client: Client) -> None:
    answer = client.submit(sample="boxes")
    seen = client.follow(answer.json()["id"])
    assert seen[-1]["state"] == "done"
    shares = [status["progress"] for status in seen]
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert {status["stage"] for status in seen} & set(STAGES.values())


def test_other_settings_need_no_second_upload(client: Client, done: str) -> None:
    ended = client.run(scene=done, settings={"preset": "paper", "k": 3})
    summary = client.get(ended["id"], "result").json()
    assert (summary["preset"], summary["k"]) == ("paper", 3)
    assert len(summary["weight_curve"]) > 3
    assert client.get(ended["id"], "data/view").json()["merges"] == []


def test_a_removed_job_leaves_nothing(client: Client, frame: Path) -> None:
    ended = client.run({"color": frame / "color.png"}, settings={"cues": "color"})
    assert client.http.delete(f"/api/jobs/{ended['id']}").status_code == 204
    assert client.get(ended["id"], "result").status_code == 404


def test_a_cancelled_job_ends_at_once_and_the_next_one_runs(client: Client) -> None:
    job = client.submit(sample="motorcycle-matched").json()["id"]
    assert client.get(job, "result").status_code == 409
    assert client.http.post(f"/api/jobs/{job}/cancel").json()["state"] == "cancelled"
    assert client.follow(job)[-1]["state"] == "cancelled"
    assert client.run(sample="boxes", settings={"preset": "fast"})["state"] == "done"


def _png_header(width: int, height: int) -> bytes:
    """A PNG that announces a size and has nothing in it."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return pack(">I", len(data)) + kind + data + pack(">I", zlib.crc32(kind + data))

    head = chunk(b"IHDR", pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("color.png", b"", "is empty"),
        ("color.png", b"\x89PNG\r\n\x1a\n cut", "cut short"),
        ("color.png", _png_header(60_000, 60_000), "pixels"),
        ("color.png", _png_header(1_000, 501), "1000 x 501 pixels, more than 500000"),
        ("color.jpg", b"\xff\xd8\xff\xe0 no picture", "cut short"),
        ("cloud.ply", b"ply\nformat ascii 1.0\nelement vertex 9999999999\n", "ply"),
        ("cloud.npz", b"PK\x03\x04 broken", "npz"),
    ],
)
def test_broken_files_and_bombs_are_refused_with_a_message(
    client: Client, tmp_path: Path, name: str, data: bytes, words: str
) -> None:
    file = tmp_path / name
    file.write_bytes(data)
    ended = client.run({file.stem: file})
    assert ended["state"] == "failed"
    assert words in ended["error"]
    assert "/" not in ended["error"].replace("and/or", "").split(":")[0]


def test_a_cloud_beyond_the_limit_is_refused(client: Client, tmp_path: Path) -> None:
    file = tmp_path / "many.npy"
    np.save(file, np.zeros((50_001, 6), np.float32))
    ended = client.run({"cloud": file})
    assert ended["state"] == "failed"
    assert "more than 50000" in ended["error"]


@pytest.mark.parametrize("told", [True, False])
def test_too_large_an_upload_is_refused(client: Client, told: bool) -> None:
    body = b"x" * (2 << 20) + b"y"
    headers = {"Content-Type": "multipart/form-data; boundary=b"}
    with httpx.Client(base_url=client.http.base_url) as fresh:
        sent = body if told else iter([body[: 1 << 20], body[1 << 20 :], b"z" * 10])
        try:
            answer = fresh.post("/api/jobs", content=sent, headers=headers)
        except (httpx.ReadError, httpx.WriteError):  # refused while it was still being sent
            return
    assert answer.status_code in (413, 422)
    assert "error" in answer.json()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ({}, "one scene"),
        ({"sample": "nowhere"}, "sample"),
        ({"sample": ["boxes"]}, "expected a text"),
        ({"sample": "boxes", "settings": []}, "JSON object"),
        ({"sample": "boxes", "settings": {"k": 0}}, "k is '0'"),
        ({"sample": "boxes", "settings": {"k": True}}, "k is"),
        ({"sample": "boxes", "settings": {"preset": "worst"}}, "preset is"),
        ({"sample": "boxes", "settings": {"weight": -1}}, "weight is"),
        ({"sample": "boxes", "settings": {"detail": "high"}}, "detail is"),
        ({"sample": "boxes", "settings": {"intrinsics": "/etc/passwd"}}, "intrinsics is"),
        ({"sample": "boxes", "settings": {"folder": "/"}}, "no field 'folder'"),
        ({"color": "/etc/passwd"}, "no field 'color'"),
    ],
)
def test_wishes_that_cannot_be_are_refused(
    client: Client, content: dict[str, Any], words: str
) -> None:
    answer = client.submit(**content)
    assert answer.status_code == 422
    assert words in answer.json()["error"]


def test_settings_that_do_not_go_together_fail_with_the_library_s_message(client: Client) -> None:
    ended = client.run(sample="boxes", settings={"k": 3, "detail": "fine"})
    assert "give one of them" in ended["error"]


def test_nothing_of_the_disk_is_served(client: Client, done: str) -> None:
    tricks = (
        "/../pyproject.toml",
        "/%2e%2e/%2e%2e/app.py",
        "/static/app.js",
        f"/api/jobs/{done}/data/..%2f..%2fetc",
        f"/api/jobs/{done}/data/scene.pickle",
        f"/api/jobs/..%2f{done}",
        f"/api/jobs/{done}/export/..%2fx",
    )
    for path in tricks:
        assert client.http.get(path).status_code == 404, path


def test_the_name_of_a_file_does_not_say_where_it_goes(client: Client, frame: Path) -> None:
    data = (frame / "color.png").read_bytes()
    for name in ("../../../tmp/evil.png", "/etc/evil.png", "C:\\evil.png", "a\x00b.png"):
        sent = {"color": (name, data)}
        answer = client.http.post("/api/jobs", data={"settings": '{"cues": "color"}'}, files=sent)
        assert answer.status_code == 202, answer.text
        client.http.delete(f"/api/jobs/{answer.json()['id']}")
    assert client.http.post("/api/jobs", files={"color": ("evil.py", data)}).status_code == 422
    assert client.http.post("/api/jobs", files={"../x": ("a.png", data)}).status_code == 422


def test_a_damaged_form_is_refused(client: Client) -> None:
    headers = {"Content-Type": "multipart/form-data; boundary=b"}
    for body in (b"", b"--b\r\nnonsense", b"--b--"):
        answer = client.http.post("/api/jobs", content=body, headers=headers)
        assert answer.status_code == 422, answer.text
    assert client.http.post("/api/jobs", content=b"<a/>").status_code == 415


def _peak_mb(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
def test_eight_users_at_once_do_not_mix_and_memory_is_bounded(
    serving: tuple[str, int], tmp_path: Path
) -> None:
    address, pid = serving
    before = _peak_mb(pid)

    def user(i: int) -> None:
        image = np.full((30 + i, 40 + 2 * i, 3), 20 * i, np.uint8)
        image[:, 20:] = 255 - 20 * i
        write_png(tmp_path / f"{i}.png", image)
        with httpx.Client(base_url=address, timeout=120) as http:
            mine = Client(http)
            ended = mine.run({"color": tmp_path / f"{i}.png"}, settings={"cues": "color"})
            assert ended["state"] == "done", ended
            view = mine.get(ended["id"], "data/view").json()
            assert view["shape"] == [30 + i, 40 + 2 * i]
            labels = np.load(io.BytesIO(mine.get(ended["id"], "export/npy").content))
            assert labels.shape == (30 + i, 40 + 2 * i)
            shown = mine.get(ended["id"], "data/color").content
            assert shown == (tmp_path / f"{i}.png").read_bytes()

    with ThreadPoolExecutor(8) as users:
        list(users.map(user, range(8)))
    assert _peak_mb(pid) < before + 150, "the server itself holds no scenes"


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_the_server_answers_while_a_worker_is_busy(client: Client) -> None:
    job = client.submit(sample="motorcycle-matched").json()["id"]
    for _ in range(20):
        assert client.http.get("/api/about", timeout=5).status_code == 200
    client.http.delete(f"/api/jobs/{job}")
