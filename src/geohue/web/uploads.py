"""From the body of a request to a job with its files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException
from starlette.formparsers import MultiPartException
from starlette.requests import Request
from starlette.types import Message

from geohue.errors import GeohueError
from geohue.web.intake import ROLES, check_roles, kept_name
from geohue.web.store import Job, Store, share_scene
from geohue.web.wishes import read_wishes

_TEXT_BYTES = 1 << 20  # of a JSON body or of the settings
_CHUNK = 1 << 20
_FIELDS = ("settings", "sample", "scene")


async def read_job(request: Request, store: Store, upload_bytes: int) -> Job:
    """Read what a request submits; its files are in the job's folder then.

    Parameters
    ----------
    request : Request
        JSON with ``sample`` or ``scene``, and ``settings``; or ``multipart/form-data`` with the
        same fields, ``settings`` as JSON text, and files named by their roles (`ROLES`).
    store : Store
    upload_bytes : int
        Most bytes of the body.

    Returns
    -------
    Job
        Not yet kept by the store.

    Raises
    ------
    GeohueError
        If it names no scene, or what is in it cannot be.
    HTTPException
        413 for a body beyond the limit.
    """
    _limit_body(request, upload_bytes)
    kind = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if kind == "application/json":
        content = await read_json(request, _TEXT_BYTES)
        if not isinstance(content, dict):
            raise GeohueError("expected a JSON object with sample or scene, and settings")
        return _job(content, {}, content.get("settings", {}), store)
    if kind != "multipart/form-data":
        raise HTTPException(415, "send multipart/form-data or application/json")
    try:
        form = request.form(max_files=len(ROLES), max_fields=8, max_part_size=_TEXT_BYTES)
        async with form as fields:
            texts = {k: v for k, v in fields.multi_items() if isinstance(v, str)}
            files = {k: v for k, v in fields.multi_items() if isinstance(v, UploadFile)}
            job = _job(texts, files, _parse(texts.get("settings") or "{}"), store)
            for role, name in job.files.items():
                await run_in_threadpool(_copy, files[role], job.folder / name)
    except MultiPartException as error:
        raise GeohueError(f"the form is damaged: {error.message[:200]}") from error
    except HTTPException as error:
        if error.status_code == 400:
            raise GeohueError(f"the form is damaged: {error.detail[:200]}") from error
        raise
    return job


async def read_json(request: Request, most: int) -> Any:
    """Read a JSON body of at most so many bytes.

    Raises
    ------
    GeohueError
        If it is no JSON.
    HTTPException
        413 for a longer one.
    """
    _limit_body(request, most)
    return _parse((await request.body()).decode("utf-8", "replace"))


def _parse(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise GeohueError("expected JSON: what was sent cannot be parsed") from error


def _job(
    texts: dict[str, Any], files: dict[str, UploadFile], settings: object, store: Store
) -> Job:
    unknown = sorted(str(name)[:40] for name in set(texts) - set(_FIELDS))
    if unknown:
        raise GeohueError(f"no field {unknown[0]!r}: there are {', '.join(_FIELDS)}")
    wishes = read_wishes(settings)
    sample, scene = (_text(texts, name) for name in ("sample", "scene"))
    names = {role: kept_name(role, file.filename or "") for role, file in files.items()}
    check_roles(names, sample, bool(scene))
    if sample:
        from geohue.datasets.samples import SAMPLES

        if sample not in SAMPLES:
            raise GeohueError(f"sample {sample[:40]!r}: choose one of {', '.join(SAMPLES)}")
    source = store.find(scene) if scene else None
    if scene and source is None:
        raise HTTPException(404, "no such job: its files may have been removed")
    key, folder = store.new_folder()
    if source is not None and not share_scene(source, folder):
        folder.rmdir()
        raise HTTPException(409, "the scene of this job has not been read: wait, or send it again")
    return Job(key, folder, wishes, names, sample)


def _text(texts: dict[str, Any], name: str) -> str:
    value = texts.get(name) or ""
    if not isinstance(value, str):
        raise GeohueError(f"{name}: expected a text")
    return value


def _copy(file: UploadFile, place: Path) -> None:
    file.file.seek(0)
    with place.open("xb") as out:
        while chunk := file.file.read(_CHUNK):
            out.write(chunk)


def _limit_body(request: Request, most: int) -> None:
    """Let the body of a request end in an error once it is longer than it may be."""
    told = request.headers.get("content-length", "0")
    if not told.isdecimal() or int(told) > most:
        raise _too_large(most)
    seen, receive = 0, request._receive

    async def counted() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > most:
            raise _too_large(most)
        return message

    request._receive = counted


def _too_large(most: int) -> HTTPException:
    return HTTPException(413, f"more than {most / 2**20:g} MB: send a smaller scene")
