"""The description of the API: it matches the routes, and whatever it allows has an answer."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import httpx
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.routing import Route

from geohue.web.app import DATA, PAGE, Api
from geohue.web.limits import Limits
from geohue.web.openapi import document
from web.client import Client

schemathesis = pytest.importorskip("schemathesis")

SCHEMA = schemathesis.openapi.from_dict(document())
OPERATIONS = [operation.ok() for operation in SCHEMA.get_all_operations()]


def test_the_document_is_served(address: str) -> None:
    assert httpx.get(f"{address}/api/openapi.json").json() == document()


def test_the_document_has_the_routes_and_no_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("geohue.web.app.Crew", lambda _: None)
    api = Api(Limits())
    routes = set()
    for route in api.routes():
        assert isinstance(route, Route)
        methods = (route.methods or set()) - {"HEAD"}
        routes |= {(route.path, method.lower()) for method in methods}
    api.store.close()
    named = {
        (path, method)
        for path, entry in document()["paths"].items()
        for method in entry
        if method != "parameters"
    }
    assert named == {(path, method) for path, method in routes if path.startswith("/api")}
    assert {path for path, _ in routes if not path.startswith("/api")} == {f"/{n}" for n in PAGE}


def test_the_document_names_all_data() -> None:
    path = document()["paths"]["/api/jobs/{job}/data/{name}"]
    assert path["parameters"][1]["schema"]["enum"] == list(DATA)


@pytest.fixture(scope="module")
def job(client: Client, frame: Path) -> str:
    """A job that is done, so that not all paths end in 404."""
    return str(client.run({"color": frame / "color.png", "depth": frame / "depth.png"})["id"])


@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda o: f"{o.method} {o.path}")
def test_no_request_is_answered_with_a_fault(operation: Any, address: str, job: str) -> None:
    """As schemathesis makes them: those that the document allows, and some that it does not."""
    answers = set(operation.definition.raw["responses"])

    @settings(
        max_examples=10,
        deadline=None,
        database=None,
        derandomize=True,
        suppress_health_check=list(HealthCheck),
    )
    @given(
        case=operation.as_strategy(),
        broken=st.booleans(),
        body=st.binary(max_size=60) | st.sampled_from([b"[]", b"1e999", b"[" * 9999]),
    )
    def ask(case: Any, broken: bool, body: bytes) -> None:
        if "job" in case.path_parameters and operation.method != "delete":
            case.path_parameters["job"] = job
        case.headers = None
        if broken and operation.method == "post":
            given_as = {"Content-Type": "application/json"}
            url = f"{address}{case.formatted_path}"
            answer = httpx.post(url, content=body, headers=given_as, timeout=60)
            status, text = answer.status_code, answer.text
        else:
            told = case.call(base_url=address)
            status, text = told.status_code, told.content.decode("utf-8", "replace")
        _check(status, text, answers)
        if status == 202:
            httpx.delete(f"{address}/api/jobs/{json.loads(text)['id']}")

    ask()


def _check(status: int, text: str, answers: set[str]) -> None:
    assert status < 500 or status == 503, text
    known = answers | {"422", "405"}  # 405: a path that a strange parameter made another one
    assert str(status) in known, (status, text)
    if status >= 400 and status != 405:
        assert json.loads(text)["error"]
