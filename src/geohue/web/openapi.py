"""The description of the API, and what there is to choose from."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from geohue._version import __version__
from geohue.datasets.samples import SAMPLES
from geohue.segmentation.clusterers import known_methods
from geohue.settings import PRESETS
from geohue.web.exports import FORMATS
from geohue.web.intake import ENDINGS, ROLES
from geohue.web.limits import Limits
from geohue.web.wishes import CUES, RULES

_DETAIL_WORDS = ("coarse", "auto", "fine")
_KINDS = ("view", "color", "regions", "depth", "points")


def about(limits: Limits) -> dict[str, Any]:
    """Return what there is to choose from, and the limits, ready for JSON."""
    return {
        "version": __version__,
        "samples": list(SAMPLES),
        "presets": list(PRESETS),
        "methods": list(known_methods()),
        "cues": list(CUES),
        "exports": list(FORMATS),
        "endings": {role: list(endings) for role, endings in ENDINGS.items()},
        "limits": asdict(limits),
    }


def document() -> dict[str, Any]:
    """Return the OpenAPI document.

    Examples
    --------
    >>> sorted(document()["paths"]["/api/jobs/{job}"])
    ['delete', 'get', 'parameters']
    """
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "geohue serve",
            "version": __version__,
            "description": "Segmentation of scenes from colour and geometry together.",
            "license": {"name": "MIT", "identifier": "MIT"},
        },
        "paths": _paths(),
        "components": {
            "schemas": _schemas(),
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
        # A server on this machine alone needs no token.
        "security": [{}, {"token": []}],
    }


def _paths() -> dict[str, Any]:
    job = [_parameter("job", "The name that POST /api/jobs answered with.")]
    formats = _parameter("format", "What to write.", list(FORMATS))
    kinds = _parameter("name", "Which data.", list(_KINDS))
    status = {"200": _json("How far it is.", "Status"), **_errors(404)}
    return {
        "/api/openapi.json": {
            "get": _operation("This document.", "openapi", _any("The document."))
        },
        "/api/about": {
            "get": _operation(
                "What there is to choose from, and the limits.",
                "about",
                _any("Samples, presets, methods, exports and limits."),
            )
        },
        "/api/jobs": {"post": _submit()},
        "/api/jobs/{job}": {
            "parameters": job,
            "get": _operation("How far a job is.", "status", status),
            "delete": _operation(
                "End a job and remove its files.",
                "remove",
                {"204": {"description": "It is gone."}, **_errors(404)},
            ),
        },
        "/api/jobs/{job}/cancel": {
            "parameters": job,
            "post": _operation("End a job; its scene stays, for other settings.", "cancel", status),
        },
        "/api/jobs/{job}/events": {
            "parameters": job,
            "get": _operation(
                "Server-sent events named progress: a Status at every change, until it ends.",
                "events",
                {"200": _binary("Events.", "text/event-stream"), **_errors(404)},
            ),
        },
        "/api/jobs/{job}/result": {
            "parameters": job,
            "get": _operation(
                "The summary: the document that geohue segment writes as result.json.",
                "result",
                {**_any("The summary."), **_errors(404, 409)},
            ),
        },
        "/api/jobs/{job}/data/{name}": {
            "parameters": [*job, kinds],
            "get": _operation(
                "What the page shows; docs/serve.md has the layout.",
                "data",
                {"200": _binary("The data.", *_DATA_TYPES), **_errors(404, 409)},
            ),
        },
        "/api/jobs/{job}/export/{format}": {
            "parameters": [*job, formats],
            "get": _operation("The segments as a file.", "export", _exported()),
            "post": _operation(
                "The same after corrections.", "exportCorrected", _exported(), _body("Corrections")
            ),
        },
    }


_DATA_TYPES = ("application/json", "image/png", "application/octet-stream")


def _submit() -> dict[str, Any]:
    files = {role: {"type": "string", "format": "binary"} for role in ROLES}
    form = {
        "type": "object",
        "properties": {
            **files,
            "sample": {"enum": list(SAMPLES)},
            "scene": {"type": "string"},
            "settings": {"type": "string", "description": "JSON of Settings."},
        },
        "additionalProperties": False,
    }
    body = _body("Submission")
    body["content"]["multipart/form-data"] = {"schema": form}
    answers = {"202": _json("It waits or runs.", "Status"), **_errors(404, 409, 413, 415, 422, 503)}
    return _operation(
        "Submit a scene: files by their roles, a sample, or the scene of an earlier job.",
        "submit",
        answers,
        body,
    )


def _exported() -> dict[str, Any]:
    kinds = sorted({form.media_type.split(";")[0] for form in FORMATS.values()})
    return {"200": _binary("The file.", *kinds), **_errors(404, 409, 413, 422)}


def _operation(
    summary: str, name: str, answers: dict[str, Any], body: dict[str, Any] | None = None
) -> dict[str, Any]:
    refused = {"401": _json("No token, or a wrong one.", "Error")}
    refused["403"] = _json("Asked by another page, or under another name.", "Error")
    operation = {"summary": summary, "operationId": name, "responses": answers | refused}
    return operation if body is None else operation | {"requestBody": body}


def _parameter(name: str, text: str, choices: list[str] | None = None) -> dict[str, Any]:
    schema = {"type": "string"} if choices is None else {"enum": choices}
    return {"name": name, "in": "path", "required": True, "description": text, "schema": schema}


def _json(text: str, schema: str) -> dict[str, Any]:
    reference = {"$ref": f"#/components/schemas/{schema}"}
    return {"description": text, "content": {"application/json": {"schema": reference}}}


def _body(schema: str) -> dict[str, Any]:
    reference = {"$ref": f"#/components/schemas/{schema}"}
    return {"required": True, "content": {"application/json": {"schema": reference}}}


def _any(text: str) -> dict[str, Any]:
    content = {"application/json": {"schema": {"type": "object"}}}
    return {"200": {"description": text, "content": content}}


def _binary(text: str, *media_types: str) -> dict[str, Any]:
    return {"description": text, "content": {kind: {} for kind in media_types}}


_ERRORS = {
    404: "There is no such thing.",
    409: "The job has not come so far.",
    413: "More than the limits allow.",
    415: "Neither a form nor JSON.",
    422: "It cannot be used; the message names the cause and the mend.",
    503: "Too many wait; Retry-After says when to try again.",
}


def _errors(*codes: int) -> dict[str, Any]:
    return {str(code): _json(_ERRORS[code], "Error") for code in codes}


def _schemas() -> dict[str, Any]:
    text, number = {"type": "string"}, {"type": "number"}
    settings = {
        "preset": {"enum": list(PRESETS)},
        "k": {"anyOf": [{"const": "auto"}, {"type": "integer", "minimum": 1, "maximum": 255}]},
        "weight": {"anyOf": [{"enum": list(RULES)}, number | {"minimum": 0}]},
        "detail": {"anyOf": [{"enum": list(_DETAIL_WORDS)}, number]},
        "cues": {"enum": list(CUES)},
        "method": {"enum": list(known_methods())},
        "seed": {"type": "integer", "minimum": 0, "maximum": 2**31 - 1},
        "depth_scale": text,
        "disparity_scale": text,
        "intrinsics": text | {"description": "fx,fy,cx,cy"},
        "calib": text | {"description": "f,baseline[,doffs[,cx,cy]]"},
    }
    return {
        "Settings": _object(settings),
        "Submission": _object(
            {
                "sample": {"enum": list(SAMPLES)},
                "scene": text,
                "settings": {"$ref": "#/components/schemas/Settings"},
            }
        ),
        "Corrections": _object(
            {
                "segment_of": {"type": "array", "items": {"type": "integer", "minimum": -1}},
                "names": {"type": "object", "additionalProperties": text | {"maxLength": 80}},
            }
        ),
        "Status": _object(
            {
                "id": text,
                "state": {"enum": ["queued", "running", "done", "failed", "cancelled"]},
                "stage": text | {"description": "In words."},
                "progress": number | {"minimum": 0, "maximum": 1},
                "error": {"type": ["string", "null"]},
                "before": {"type": "integer", "minimum": 0, "description": "Jobs before it."},
            },
            all_required=True,
        ),
        "Error": _object({"error": text}, all_required=True),
    }


def _object(properties: dict[str, Any], all_required: bool = False) -> dict[str, Any]:
    schema = {"type": "object", "properties": properties, "additionalProperties": False}
    return schema | ({"required": list(properties)} if all_required else {})
