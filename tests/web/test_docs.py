"""The examples of docs/serve.md, and the command's own words."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from geohue.cli.app import app
from geohue.read.images.pictures import read_labels
from geohue.web.exports import FORMATS
from geohue.web.intake import ROLES

DOCS = (Path(__file__).parents[2] / "docs/serve.md").read_text(encoding="utf-8")


def test_the_client_of_the_docs_works(
    address: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = re.search(r"```python\n(.*?)```", DOCS, re.DOTALL)
    assert found
    code = found.group(1)
    assert len(code.splitlines()) <= 10
    assert "http://127.0.0.1:8484" in code
    assert "motorcycle" in code
    monkeypatch.chdir(tmp_path)
    small = code.replace("http://127.0.0.1:8484", address).replace("motorcycle", "boxes")
    exec(compile(small, "docs/serve.md", "exec"), {})
    printed = capsys.readouterr().out.splitlines()
    assert read_labels("labels.png").max() == int(printed[-1])
    assert "merging regions" in printed


def test_the_docs_name_all_exports_and_roles() -> None:
    for name in (*FORMATS, *ROLES):
        assert f"`{name}`" in DOCS, name


def test_the_options_of_the_docs_are_those_of_the_command() -> None:
    text = CliRunner().invoke(app, ["serve", "--help"], env={"COLUMNS": "200"}).output
    for option in re.findall(r"`(--[a-z-]+)", DOCS):
        assert option in text, option


def test_without_the_extra_the_message_says_how_to_get_it() -> None:
    code = (
        "import sys; sys.modules['starlette'] = sys.modules['uvicorn'] = None;"
        "from geohue.cli import main; main(['serve', '--port', '0', '--no-open'])"
    )
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    ended = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 2
    assert 'pip install "geohue[web]"' in ended.stderr
    assert "Traceback" not in ended.stderr
