"""The routes of the page and of its JSON API."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from importlib.resources import files
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from geohue.errors import GeohueError
from geohue.web.crew import Crew
from geohue.web.door import Door
from geohue.web.exporting import export_file
from geohue.web.guard import Guard, refuse
from geohue.web.limits import Limits
from geohue.web.openapi import about, document
from geohue.web.store import Job, Store
from geohue.web.uploads import read_job, read_json

PAGE = {
    "": ("index.html", "text/html"),
    "app.js": ("app.js", "text/javascript"),
    "style.css": ("style.css", "text/css"),
    "icon.svg": ("icon.svg", "image/svg+xml"),
}
"""The files of the page, by the end of their address; nothing else is served from the disk."""

DATA = {
    "view": ("view.json", "application/json"),
    "color": ("color.png", "image/png"),
    "regions": ("regions.bin", "application/octet-stream"),
    "depth": ("depth.bin", "application/octet-stream"),
    "points": ("points.bin", "application/octet-stream"),
}
"""What the page gets of a job that is done."""

_CORRECTIONS_BYTES = 8 << 20
_LOOK = 0.05  # seconds between looks at how far a job is
_SIGN_OF_LIFE = 15.0  # seconds
_SWEEP = 5.0  # seconds
_UPLOADS = 4  # at a time


class Api:
    """The server's state, and an endpoint for each route.

    Parameters
    ----------
    limits : Limits
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.store = Store(limits)
        self.crew = Crew(limits)
        self._uploads = asyncio.Semaphore(_UPLOADS)
        self._exports = asyncio.Semaphore(1)  # an export holds a whole scene in memory

    def routes(self) -> list[BaseRoute]:
        """Return all routes."""
        one = "/api/jobs/{job}"
        return [
            *(Route(f"/{name}", self.page, methods=["GET"]) for name in PAGE),
            Route("/api/openapi.json", self.openapi, methods=["GET"]),
            Route("/api/about", self.about, methods=["GET"]),
            Route("/api/jobs", self.submit, methods=["POST"]),
            Route(one, self.status, methods=["GET"]),
            Route(one, self.remove, methods=["DELETE"]),
            Route(f"{one}/cancel", self.cancel, methods=["POST"]),
            Route(f"{one}/events", self.events, methods=["GET"]),
            Route(f"{one}/result", self.result, methods=["GET"]),
            Route(f"{one}/data/{{name}}", self.data, methods=["GET"]),
            Route(f"{one}/export/{{format}}", self.export, methods=["GET", "POST"]),
        ]

    async def page(self, request: Request) -> Response:
        """Answer with a file of the page."""
        name, media_type = PAGE[request.url.path.removeprefix("/")]
        content = (files("geohue.web") / "static" / name).read_bytes()
        return Response(content, media_type=media_type)

    async def openapi(self, _: Request) -> Response:
        """Answer with the description of the API."""
        return JSONResponse(document())

    async def about(self, _: Request) -> Response:
        """Answer with what there is to choose from, and the limits."""
        return JSONResponse(about(self.limits))

    async def submit(self, request: Request) -> Response:
        """Take a scene, and answer with the name of its job."""
        if self.crew.is_full:
            return self._busy()
        async with self._uploads:
            job = await read_job(request, self.store, self.limits.upload_bytes)
        self.store.add(job)
        if not self.crew.submit(job):
            self.store.remove(job)
            return self._busy()
        headers = {"Location": f"/api/jobs/{job.key}"}
        return JSONResponse(job.status(), 202, headers)

    def _busy(self) -> Response:
        message = f"{self.limits.waiting} scenes are waiting: try again in a moment"
        return refuse(503, message, {"Retry-After": "5"})

    async def status(self, request: Request) -> Response:
        """Answer with how far a job is."""
        return JSONResponse(self._status(self._job(request)))

    async def remove(self, request: Request) -> Response:
        """End a job and remove its files."""
        job = self._job(request)
        self.crew.cancel(job)
        await run_in_threadpool(self.store.remove, job)
        return Response(status_code=204)

    async def cancel(self, request: Request) -> Response:
        """End a job; its scene stays, for other settings."""
        job = self._job(request)
        self.crew.cancel(job)
        return JSONResponse(self._status(job))

    async def events(self, request: Request) -> Response:
        """Answer with how far a job is, again at every change until it ends."""
        job = self._job(request)
        return StreamingResponse(self._follow(job), media_type="text/event-stream")

    async def _follow(self, job: Job) -> AsyncIterator[str]:
        last, silent = "", 0.0
        while True:
            ended = job.ended  # before the text, so that the end is never left out
            text = json.dumps(self._status(job))
            if text != last:
                last, silent = text, 0.0
                yield f"event: progress\ndata: {text}\n\n"
            elif silent >= _SIGN_OF_LIFE:
                silent = 0.0
                yield ": still here\n\n"
            if ended:
                return
            await asyncio.sleep(_LOOK)
            silent += _LOOK

    async def result(self, request: Request) -> Response:
        """Answer with the summary of a result, the document that ``result.json`` is."""
        return await self._data(self._done(request), "result.json", "application/json")

    async def data(self, request: Request) -> Response:
        """Answer with what the page shows."""
        job, name = self._done(request), request.path_params["name"]
        if name not in DATA:
            raise HTTPException(404, f"no such data: there are {', '.join(DATA)}")
        return await self._data(job, *DATA[name])

    async def _data(self, job: Job, name: str, media_type: str) -> Response:
        if not (job.folder / name).is_file():
            raise HTTPException(404, "this scene has none")
        return FileResponse(job.folder / name, media_type=media_type)

    async def export(self, request: Request) -> Response:
        """Answer with the segments as a file, with the corrections that are sent."""
        job, name = self._done(request), request.path_params["format"]
        content = {}
        if request.method == "POST":
            content = await read_json(request, _CORRECTIONS_BYTES)
        async with self._exports:
            return await run_in_threadpool(export_file, job.folder, name, content)

    def _status(self, job: Job) -> dict[str, Any]:
        return job.status() | {"before": self.crew.place(job)}

    def _job(self, request: Request) -> Job:
        job = self.store.find(request.path_params["job"])
        if job is None:
            raise HTTPException(404, "no such job: its files may have been removed")
        return job

    def _done(self, request: Request) -> Job:
        job = self._job(request)
        if job.state != "done":
            raise HTTPException(
                409, f"the job is {job.state}" + (f": {job.error}" * bool(job.error))
            )
        return job

    @contextlib.asynccontextmanager
    async def running(self, _: Starlette) -> AsyncIterator[None]:
        """Remove old files from time to time, and everything at the end."""
        sweeper = asyncio.create_task(self._sweep())
        try:
            yield
        finally:
            sweeper.cancel()
            await run_in_threadpool(self.close)

    async def _sweep(self) -> None:
        while True:
            await asyncio.sleep(_SWEEP)
            await run_in_threadpool(self.store.sweep)

    def close(self) -> None:
        """End the workers and remove all files."""
        self.crew.close()
        self.store.close()


def make_app(limits: Limits, door: Door) -> Starlette:
    """Return the application.

    Parameters
    ----------
    limits : Limits
        What it takes and keeps.
    door : Door
        Who is let in.

    Returns
    -------
    Starlette
        Its worker processes run already, and end with its lifespan.
    """
    api = Api(limits)

    async def said(_: Request, error: Exception) -> Response:
        if isinstance(error, HTTPException):
            return refuse(error.status_code, error.detail, error.headers)
        return refuse(422, str(error)[:1000])

    return Starlette(
        routes=api.routes(),
        middleware=[Middleware(Guard, door=door)],
        exception_handlers={GeohueError: said, HTTPException: said},
        lifespan=api.running,
    )
