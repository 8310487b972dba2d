"""Whatever is sent to the server, it answers with a job or one line of JSON, and goes on.

`GEOHUE_FUZZ_CASES` sets the number of cases (`make fuzz`).
"""

from __future__ import annotations

import json
from typing import Any

import httpx
from hypothesis import given
from hypothesis import strategies as st

from strange import relaxed
from web.client import Client

SETTINGS = ("preset", "k", "weight", "cues", "detail", "components", "seed", "fill", "method")
NAMES = ("sample", "scene", "settings", "intrinsics", "depth_scale", "calib", "color", "depth")
VALUES: st.SearchStrategy[Any] = st.one_of(
    st.sampled_from(["boxes", "best", "paper", "auto", "x", "", "../x", "\x00", "9" * 400]),
    st.sampled_from([0, 1, -1, 10**30, 1e308, True, None, [], {}, [[]], "1,1,1,1", "inf"]),
    st.text(max_size=8),
)
WISHES = st.dictionaries(st.sampled_from(SETTINGS), VALUES, max_size=3)
BODIES = st.dictionaries(st.sampled_from(NAMES), st.one_of(VALUES, WISHES), max_size=4)
BYTES = st.one_of(
    st.binary(max_size=60),
    st.sampled_from([b"\x89PNG\r\n\x1a\n", b"ply\nformat ascii 1.0\n", b"LASF", b"PK\x03\x04"]),
)
ROLES = ("color", "depth", "cloud", "left", "right", "disparity", "calib", "rig", "x")


def is_answer(client: Client, answer: httpx.Response) -> None:
    if answer.status_code == 202:
        job = answer.json()["id"]
        assert client.http.delete(f"/api/jobs/{job}").status_code == 204
        return
    assert answer.status_code in (400, 404, 405, 409, 411, 413, 415, 422, 503), answer.text
    message = answer.json()["error"]
    assert message
    assert "\n" not in message
    assert "Traceback" not in message


@relaxed(30)
@given(body=st.one_of(BODIES.map(lambda b: json.dumps(b).encode()), st.binary(max_size=40)))
def test_any_json(client: Client, body: bytes) -> None:
    kind = {"Content-Type": "application/json"}
    is_answer(client, client.http.post("/api/jobs", content=body, headers=kind))


@relaxed(30)
@given(
    files=st.dictionaries(
        st.sampled_from(ROLES),
        st.tuples(st.sampled_from(["a.png", "a.ply", "a.npz", "a", "../a.las"]), BYTES),
        max_size=3,
    ),
    wishes=WISHES,
)
def test_any_upload(client: Client, files: dict[str, Any], wishes: dict[str, Any]) -> None:
    fields = {"settings": json.dumps(wishes)}
    is_answer(client, client.http.post("/api/jobs", data=fields, files=files))


@relaxed(30)
@given(
    words=st.lists(
        st.sampled_from(["api", "jobs", "x", "..", "%2e%2e", "%00", "result", "data", "export"]),
        max_size=5,
    ),
    method=st.sampled_from(["GET", "POST", "PUT", "DELETE", "HEAD"]),
)
def test_any_address(client: Client, words: list[str], method: str) -> None:
    answer = client.http.request(method, "/" + "/".join(words))
    assert answer.status_code < 500
