"""Camera files as mappings: JSON, OpenCV's XML, and the YAML that OpenCV and ROS write.

Calibration YAML is nested keys with lists of numbers, which a few lines read; OpenCV's own parser
raises SystemError on damaged files and does not take ROS's lists of dashes.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from geohue.read.files import broken, reason

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_NUMBERS = re.compile(rf"(?<![\w.]){NUMBER}(?![\w.])")
_KEY = re.compile(r"""^(?P<indent>[ \t]*)["']?(?P<key>[A-Za-z_]\w*)["']?[ \t]*:(?=\s|$|\[|!)""")
_MOST_NUMBERS = 100  # a camera has no longer list; calibration files also keep all corners
_DEEPEST = 6


def parse_camera_text(text: str, path: str | Path) -> Any:
    """Return the content of a JSON, XML or YAML file as nested dicts and lists of numbers.

    Parameters
    ----------
    text : str
        The file's text.
    path : path-like
        Named in errors.

    Returns
    -------
    dict, list or None
        None if the text is none of the three.

    Raises
    ------
    GeohueError
        If the text begins as JSON or XML and is damaged.
    """
    start = text.lstrip()[:1]
    if start == "{":
        try:
            return json.loads(text)
        except (ValueError, RecursionError) as error:
            raise broken(path, f"is damaged JSON ({reason(error)}); export it again") from error
    if start == "<":
        return _parse_xml(text, path)
    content = _parse_yaml(text.splitlines(), 0)
    return content or None


def _parse_xml(text: str, path: str | Path) -> Any:
    if "<!" in re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL):
        raise broken(path, "has XML declarations that no camera file needs; remove them")
    try:
        return _from_element(ElementTree.fromstring(text), 0)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise broken(path, f"is damaged XML ({reason(error)}); export it again") from error


def _from_element(element: ElementTree.Element, depth: int) -> Any:
    if len(element) and depth < _DEEPEST:
        return {child.tag: _from_element(child, depth + 1) for child in element}
    text = (element.text or "").strip()
    return _leaf(f"[{text}]" if len(text.split()) > 1 else text)


def _parse_yaml(lines: list[str], depth: int) -> dict[str, Any]:
    """Return the keys of the smallest indent, each with its scalar, list or inner keys."""
    keys = [(i, match) for i, line in enumerate(lines) if (match := _KEY.match(line))]
    if not keys or depth > _DEEPEST:
        return {}
    indent = min(len(match["indent"]) for _, match in keys)
    tops = [(i, match) for i, match in keys if len(match["indent"]) == indent]
    content: dict[str, Any] = {}
    for number, (i, match) in enumerate(tops):
        end = tops[number + 1][0] if number + 1 < len(tops) else len(lines)
        block = lines[i + 1 : end]
        inner = _parse_yaml(block, depth + 1)
        content[match["key"]] = inner or _leaf("\n".join([lines[i][match.end() :], *block]))
    return content


def _leaf(text: str) -> Any:
    r"""Return a list of numbers, a number, or the text.

    Examples
    --------
    >>> _leaf("[1.5, -2,\n 3e2]"), _leaf("- 1.0\n- -2"), _leaf("-7"), _leaf("cam")
    ([1.5, -2.0, 300.0], [1.0, -2.0], -7.0, 'cam')
    """
    text = re.sub(r"(?m)(^|\s)#.*$", "", text).strip()
    if text.startswith("[") or re.match(r"-\s", text):
        found = _NUMBERS.findall(text[:100_000])
        return [float(x) for x in found] if len(found) <= _MOST_NUMBERS else None
    return float(text) if re.fullmatch(NUMBER, text) else text
