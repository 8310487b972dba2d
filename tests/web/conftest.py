"""One server and one browser for all tests of the page, and small scenes as files."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Scene
from geohue.read.scenes.scenes import read_scene
from geohue.results.ply import write_ply
from geohue.results.png import write_png
from web.client import Client

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = Path("/usr/bin/chromium")

_FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader "
    "--enable-unsafe-swiftshader"
)


@pytest.fixture(scope="session")
def serving(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, int]]:
    """A running ``geohue serve``: its address and the number of its process."""
    place = tmp_path_factory.mktemp("serve")
    command = [sys.executable, "-m", "geohue", "serve", "--port", "0", "--no-open"]
    limits = ["--max-upload", "2", "--max-pixels", "500000", "--max-points", "50000"]
    environment = os.environ | {
        "TMPDIR": str(place),
        "PYTHONPATH": os.pathsep.join(sys.path),
        "PYTHONUNBUFFERED": "1",
    }
    process = subprocess.Popen(
        command + limits, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.search(r"http://\S+", line)
    assert found, line + process.communicate()[1]
    yield found.group().rstrip("/"), process.pid
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert "Traceback" not in errors, errors
    assert list(place.iterdir()) == [], "files stayed behind"


@pytest.fixture(scope="session")
def address(serving: tuple[str, int]) -> str:
    return serving[0]


@pytest.fixture(scope="session")
def client(address: str) -> Iterator[Client]:
    with httpx.Client(base_url=address, timeout=120) as http:
        yield Client(http)


@pytest.fixture(scope="session")
def frame(
    three_boxes: tuple[Scene, NDArray[np.int32]], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A folder with ``color.png`` and ``depth.png`` in millimetres."""
    folder, (scene, _) = tmp_path_factory.mktemp("frame"), three_boxes
    assert scene.depth is not None
    write_png(folder / "color.png", scene.colors)
    write_png(folder / "depth.png", (scene.depth * 1000).round().astype(np.uint16))
    return folder


@pytest.fixture(scope="session")
def frame_scene(frame: Path) -> Scene:
    return read_scene(frame / "color.png", frame / "depth.png")


@pytest.fixture(scope="session")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a stereo pair, ``left.png`` and ``right.png``."""
    folder = tmp_path_factory.mktemp("pair")
    wide = np.random.default_rng(0).integers(0, 256, (60, 120, 3)).astype(np.uint8)
    write_png(folder / "left.png", wide[:, :-8])
    write_png(folder / "right.png", wide[:, 8:])
    return folder


@pytest.fixture(scope="session")
def cloud(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A PLY file with two coloured balls apart."""
    rng = np.random.default_rng(1)
    ball = rng.normal(size=(1500, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    points = np.concatenate([ball, ball + np.array([4, 0, 0])])
    colors = np.repeat(np.array([[200, 40, 40], [40, 60, 200]], np.uint8), 1500, axis=0)
    file = tmp_path_factory.mktemp("cloud") / "balls.ply"
    write_ply(file, points, colors, np.zeros(3000, np.int32))
    return file


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    if not CHROMIUM.exists():
        if os.environ.get("GEOHUE_BROWSER") == "required":
            pytest.fail(f"no browser at {CHROMIUM}")
        pytest.skip(f"no browser at {CHROMIUM}: install Debian's chromium")
    sync = pytest.importorskip("playwright.sync_api")
    with sync.sync_playwright() as playwright:
        found = playwright.chromium.launch(
            executable_path=str(CHROMIUM), headless=True, args=_FLAGS.split()
        )
        yield found
        found.close()


OpenPage = Callable[..., "Page"]


@pytest.fixture
def open_page(browser: Browser, address: str) -> Iterator[OpenPage]:
    """Opens the page in a tab of its own; asks nobody else for anything, and has no errors."""
    contexts: list[Any] = []
    asked: list[str] = []
    errors: list[str] = []

    def opened(query: str = "", **options: Any) -> Page:
        context = browser.new_context(viewport={"width": 1100, "height": 750}, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(60_000)
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda m: errors.append(m.text) if "Security Policy" in m.text else None)
        page.goto(f"{address}/{query}")
        page.wait_for_selector("html[data-ready]")
        return page

    yield opened
    for context in contexts:
        context.close()
    assert [url for url in asked if not url.startswith((f"{address}/", "blob:", "about:"))] == []
    assert errors == []
