"""Who is let in."""

from __future__ import annotations

import asyncio

import httpx
import pytest
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route

from geohue.errors import GeohueError
from geohue.web.guard import COOKIE, HEADERS, Guard
from geohue.web.server import door_for, listen


def _ask(guard: Guard, path: str = "/", **headers: str) -> httpx.Response:
    async def go() -> httpx.Response:
        transport = httpx.ASGITransport(app=guard)
        async with httpx.AsyncClient(transport=transport, base_url="http://127.0.0.1:80") as http:
            named = {name.replace("_", "-"): value for name, value in headers.items()}
            return await http.get(path, headers=named)

    return asyncio.run(go())


def _guard(host: str, token: str = "") -> Guard:
    async def answer(_: object) -> PlainTextResponse:
        return PlainTextResponse("inside")

    routes = [Route(path, answer) for path in ("/", "/api/about")]
    return Guard(Starlette(routes=routes), door_for(host, token))


@pytest.mark.parametrize("host", ["127.0.0.1:80", "localhost:1234", "[::1]:80", "LOCALHOST"])
def test_own_names_are_let_in(host: str) -> None:
    assert _ask(_guard("127.0.0.1"), host=host).text == "inside"


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:80", "127.0.0.1.evil.example", "10.0.0.1", "", "["]
)
def test_names_that_another_page_had_resolved_are_not(host: str) -> None:
    assert _ask(_guard("127.0.0.1"), host=host).status_code == 403


def test_other_pages_are_refused_and_the_own_page_is_not() -> None:
    guard, api = _guard("127.0.0.1"), "/api/about"
    own = {"host": "localhost:8"}
    assert _ask(guard, api, **own, origin="http://localhost:8").status_code == 200
    for origin in ("http://evil.example", "null", "http://localhost:9", "https://localhost:8"):
        assert _ask(guard, api, **own, origin=origin).status_code == 403
    for site in ("cross-site", "same-site"):
        assert _ask(guard, api, **own, sec_fetch_site=site).status_code == 403
        assert _ask(guard, "/", **own, sec_fetch_site=site).status_code == 200  # a link to the page
    assert _ask(guard, api, **own, sec_fetch_site="same-origin").status_code == 200


def test_beyond_this_machine_the_token_is_needed() -> None:
    guard = _guard("0.0.0.0", "secret")
    assert _ask(guard).status_code == 401
    assert _ask(guard, "/api/about", authorization="Bearer wrong").status_code == 401
    assert _ask(guard, "/api/about?token=secret").status_code == 401
    assert _ask(guard, "/api/about", authorization="Bearer secret").text == "inside"
    assert _ask(guard, "/", cookie=f"{COOKIE}=secret").text == "inside"
    assert _ask(guard, "/", cookie=f"{COOKIE}=s").status_code == 401
    opened = _ask(guard, "/?token=secret")
    assert opened.status_code == 303
    assert opened.headers["location"] == "/"
    assert "HttpOnly" in opened.headers["set-cookie"]
    assert "samesite=strict" in opened.headers["set-cookie"].lower()


def test_a_server_for_others_knows_addresses_but_no_foreign_names() -> None:
    guard = _guard("0.0.0.0", "secret")
    known = {"authorization": "Bearer secret"}
    assert _ask(guard, host="192.168.1.7:8484", **known).text == "inside"
    assert _ask(guard, host="evil.example", **known).status_code == 403


def test_a_token_is_made_up_where_none_is_given() -> None:
    one, other = door_for("0.0.0.0"), door_for("192.168.1.7")
    assert len(one.token) >= 32
    assert one.token != other.token
    assert door_for("127.0.0.1", "mine").token == "mine"


@pytest.mark.parametrize("host", ["127.0.0.1", "evil.example"])
def test_every_answer_has_the_safe_headers(host: str) -> None:
    answer = _ask(_guard("127.0.0.1"), host=host)
    for name, value in HEADERS.items():
        assert answer.headers[name] == value
    policy = HEADERS["Content-Security-Policy"]
    assert "unsafe" not in policy
    assert "default-src 'none'" in policy


def test_a_port_that_is_taken_is_one_message() -> None:
    with listen("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        with pytest.raises(GeohueError, match="give another --port"):
            listen("127.0.0.1", port)
    with pytest.raises(GeohueError, match="give an address"):
        listen("no such host", 0)
