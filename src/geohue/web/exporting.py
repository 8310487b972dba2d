"""An export as the answer to a request."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from starlette.exceptions import HTTPException
from starlette.responses import Response

from geohue.errors import GeohueError
from geohue.web.exports import FORMATS
from geohue.web.taken import taken
from geohue.web.work import kept_run, without_paths


def export_file(folder: Path, name: str, content: Any) -> Response:
    """Write an export, and answer with it.

    Parameters
    ----------
    folder : Path
        Of a job that is done.
    name : str
        Of `FORMATS`.
    content : object
        A mapping with ``segment_of`` and ``names`` (`taken`), both of which may be missing.

    Raises
    ------
    GeohueError
        For corrections that do not fit, or a format that does not fit the scene.
    HTTPException
        404 for an unknown format.
    """
    if name not in FORMATS:
        raise HTTPException(404, f"no such export: there are {', '.join(FORMATS)}")
    if not isinstance(content, dict) or set(content) - {"segment_of", "names"}:
        raise GeohueError("expected a JSON object with segment_of and names, or none of them")
    what = taken(*kept_run(folder), content.get("segment_of"), content.get("names"))
    form = FORMATS[name]
    with tempfile.TemporaryDirectory(dir=folder) as place:
        file = Path(place) / form.file
        try:
            form.write(file, what)
        except GeohueError as error:
            raise GeohueError(without_paths(str(error), Path(place))) from error
        data = file.read_bytes()
    headers = {"Content-Disposition": f'attachment; filename="{form.file}"'}
    return Response(data, media_type=form.media_type, headers=headers)
