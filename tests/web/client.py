"""A client of the API for tests."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import httpx


class Client:
    """Submits scenes and follows them to their end."""

    def __init__(self, http: httpx.Client) -> None:
        self.http = http

    def submit(self, files: dict[str, Path] | None = None, **content: Any) -> httpx.Response:
        """Send files by their roles with settings, or JSON alone."""
        if files is None:
            return self.http.post("/api/jobs", json=content)
        fields = {"settings": json.dumps(content.pop("settings", {}))} | content
        sent = {role: (file.name, file.read_bytes()) for role, file in files.items()}
        return self.http.post("/api/jobs", data=fields, files=sent)

    def follow(self, job: str) -> list[dict[str, Any]]:
        """Return every status of a job until it ends."""
        seen = []
        with self.http.stream("GET", f"/api/jobs/{job}/events") as events:
            for line in events.iter_lines():
                if line.startswith("data: "):
                    seen.append(json.loads(line.removeprefix("data: ")))
        return seen

    def run(self, files: dict[str, Path] | None = None, **content: Any) -> dict[str, Any]:
        """Submit a scene and return its last status."""
        answer = self.submit(files, **content)
        assert answer.status_code == 202, answer.text
        last: dict[str, Any] = self.follow(answer.json()["id"])[-1]
        return last

    def get(self, job: str, what: str) -> httpx.Response:
        """Return the answer about a job."""
        return self.http.get(f"/api/jobs/{job}/{what}")
