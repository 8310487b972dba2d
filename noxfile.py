"""The extras alone and together, and the oldest and newest versions of what geohue needs.

``nox`` runs all of it, ``nox -s extras`` the extras. Environments are made by uv in seconds.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import nox

nox.options.default_venv_backend = "uv"
nox.options.reuse_existing_virtualenvs = True

PROJECT = tomllib.loads(Path("pyproject.toml").read_text("utf-8"))["project"]
TESTING = ("pytest>=8.2", "hypothesis>=6.100")

# What an extra adds, and the tests of it. A new extra without a line here fails.
FEATURES = {
    "clouds": ["tests/read/clouds"],
    "datasets": ["tests/datasets"],
    "ros": ["tests/datasets"],
    "sklearn": ["tests/spectral", "docs/estimator.md"],
    "distributed": ["tests/jobs"],
    "meshes": ["tests/read/clouds/test_mesh.py"],
    "phones": ["tests/datasets/test_phones.py"],
    "web": ["tests/web/test_guard.py", "tests/web/test_views.py"],
    "video": ["tests/video", "tests/cli/test_video.py"],
    "realsense": ["tests/video"],
}
EXTRAS = sorted(set(PROJECT["optional-dependencies"]) - {"dev", "docs"})
CORE = ["tests/cli/test_cli.py", "tests/segmentation", "tests/merge/test_segment.py", "README.md"]


def check(session: nox.Session, install: str, tests: list[str], *resolution: str) -> None:
    """Install the project, import every file of it, and run some tests."""
    session.install("-e", install, *TESTING, *resolution)
    session.run("python", "tests/import_all.py")
    # The oldest libraries use what newer ones call deprecated; that is theirs.
    quiet = ("-W", "ignore::DeprecationWarning") if resolution else ()
    session.run("python", "-m", "pytest", "-q", "-p", "no:cacheprovider", *quiet, *tests)


@nox.session
@nox.parametrize("extra", EXTRAS)
def extras(session: nox.Session, extra: str) -> None:
    """One extra by itself, with the tests of what it adds."""
    check(session, f".[{extra}]", FEATURES[extra])


@nox.session
def none(session: nox.Session) -> None:
    """No extra."""
    check(session, ".", CORE)


@nox.session
def all(session: nox.Session) -> None:  # noqa: A001  a session is called as users say it
    """Every extra together."""
    check(session, f".[{','.join(EXTRAS)}]", CORE)


@nox.session
@nox.parametrize("resolution", ["lowest-direct", "highest"])
def versions(session: nox.Session, resolution: str) -> None:
    """The oldest versions that the project declares, and the newest that there are."""
    session.env["NUMBA_CACHE_DIR"] = str(Path(session.create_tmp()) / "compiled")
    check(session, ".", CORE, "--resolution", resolution)
