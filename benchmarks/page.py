"""How quickly the page of ``geohue serve`` answers: the slider, and clouds that turn.

``python benchmarks/page.py`` needs Debian's chromium and the packages of the tests. The browser has
no graphics processor here: the page draws the points itself.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geohue.results.ply import write_ply

if TYPE_CHECKING:
    from playwright.sync_api import Browser

CHROMIUM = "/usr/bin/chromium"
FLAGS = ("--no-sandbox", "--disable-gpu", "--disable-background-networking")
COUNTS = (100_000, 1_000_000)

_SLIDE = """() => {
  const slider = document.getElementById('detail'), spent = [];
  for (let detail = -4; detail <= 4; detail += 0.1) {
    slider.value = detail;
    slider.dispatchEvent(new Event('input'));
    spent.push(Number(slider.dataset.ms));
  }
  return spent;
}"""

_TURN = """async () => {
  const view = document.querySelector('.pane canvas:not(.flat)'), times = [];
  const begin = performance.now();
  await new Promise((done) => {
    const step = (now) => {
      times.push(now);
      view.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft' }));
      if (performance.now() - begin < 5000) requestAnimationFrame(step);
      else done();
    };
    requestAnimationFrame(step);
  });
  const kept = times.slice(60);
  return [kept.slice(60).map((t, i) => t - kept[i]), Number(view.dataset.drawn)];
}"""


def slider(browser: Browser, address: str) -> None:
    """Print how long a move of the slider takes on the motorcycle, drawing included."""
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.goto(address)
    page.select_option("#sample", "motorcycle")
    page.wait_for_selector("#told:not(:empty)", timeout=120_000)
    spent = np.array(page.evaluate(_SLIDE))
    print(f"slider: median {np.median(spent):.1f} ms, longest {spent.max():.1f} ms")
    page.close()


def turn(browser: Browser, address: str, n: int) -> None:
    """Print how many frames a second a cloud turns at, over whole seconds after the first."""
    points = np.random.default_rng(0).normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    points[: n // 2, 0] += 2.5
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "cloud.ply"
        write_ply(file, points, (np.abs(points) * 80).astype(np.uint8), np.zeros(n, np.int32))
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(address)
        page.set_input_files("#files", file)
        page.wait_for_selector("#told:not(:empty)", timeout=120_000)
    page.wait_for_timeout(1000)
    sixty, drawn = page.evaluate(_TURN)
    pace = 60_000 / np.median(sixty)
    print(f"{n:,} points: {pace:.0f} frames a second, {drawn:,} points a frame")
    page.close()


def main() -> None:
    """Serve, measure and stop."""
    from playwright.sync_api import sync_playwright

    command = [sys.executable, "-u", "-m", "geohue", "serve", "--port", "0", "--no-open"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        found = re.search(r"http://\S+", server.stdout.readline())
        assert found is not None
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=CHROMIUM, headless=True, args=list(FLAGS)
            )
            slider(browser, found.group())
            for n in COUNTS:
                turn(browser, found.group(), n)
            browser.close()
        server.terminate()


if __name__ == "__main__":
    main()
