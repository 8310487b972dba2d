"""What the decoders of pictures print to the terminal, kept from there and read."""

from __future__ import annotations

import os
import re
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_LINES = re.compile(
    rb"(?m)^(?:Corrupt JPEG data|Premature end of JPEG|Invalid JPEG|Unsupported|Inconsistent|"
    rb"Invalid SOS|Unknown|Warning: unknown JFIF|libpng|JPEG datastream).*$\n?"
)
_HARMLESS = re.compile(r"extraneous bytes before marker|unknown JFIF|Unknown Adobe")
_ONE = threading.Lock()


@contextmanager
def listened() -> Iterator[list[str]]:
    """Keep the lines of the C libraries for JPEG and PNG from standard error; yields them after.

    What others write meanwhile goes to standard error when the block ends. Blocks of several
    threads take turns.
    """
    lines: list[str] = []
    with _ONE, _opencv_quiet(), tempfile.TemporaryFile() as kept:
        sys.stderr.flush()
        try:
            before = os.dup(2)
        except OSError:  # there is no standard error
            yield lines
            return
        try:
            os.dup2(kept.fileno(), 2)
            yield lines
        finally:
            sys.stderr.flush()
            os.dup2(before, 2)
            os.close(before)
            kept.seek(0)
            said = kept.read()
            lines += [line.decode("latin-1").strip() for line in _LINES.findall(said)]
            if rest := _LINES.sub(b"", said):
                os.write(2, rest)


def harmful(lines: list[str]) -> list[str]:
    """Return the lines that speak of lost pixels.

    Examples
    --------
    >>> harmful(["Corrupt JPEG data: 2 extraneous bytes before marker 0xd9"])
    []
    >>> harmful(["Corrupt JPEG data: premature end of data segment"])
    ['Corrupt JPEG data: premature end of data segment']
    """
    return [line for line in lines if not _HARMLESS.search(line)]


@contextmanager
def _opencv_quiet() -> Iterator[None]:
    """Keep OpenCV itself from printing what the error says anyway."""
    import cv2

    logging: Any = getattr(cv2.utils, "logging", cv2)  # OpenCV 5 and 4
    level = logging.getLogLevel()
    logging.setLogLevel(0)
    try:
        yield
    finally:
        logging.setLogLevel(level)
