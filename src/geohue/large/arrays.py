"""Dataclasses of arrays and numbers, kept as NPZ: no code is run when one is read back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, get_type_hints

import numpy as np
from numpy.typing import NDArray

Kind = TypeVar("Kind")


def to_arrays(value: Any, prefix: str = "") -> dict[str, NDArray[Any]]:
    """Return the fields of a dataclass, and of those inside it, by dotted names.

    Examples
    --------
    >>> from geohue.large.vectors import Standard
    >>> sorted(to_arrays(Standard(np.zeros(6), np.ones(2), "fusion")))
    ['cues', 'mean', 'sigma']
    """
    arrays: dict[str, NDArray[Any]] = {}
    for item in fields(value):
        content = getattr(value, item.name)
        if is_dataclass(content):
            arrays |= to_arrays(content, f"{prefix}{item.name}.")
        else:
            arrays[prefix + item.name] = np.asarray(content)
    return arrays


def from_arrays(kind: type[Kind], arrays: Mapping[str, NDArray[Any]], prefix: str = "") -> Kind:
    """Return the dataclass that `to_arrays` took apart."""
    hints = get_type_hints(kind)
    parts: dict[str, Any] = {}
    for item in fields(kind):  # type: ignore[arg-type]  # a dataclass
        hint = hints[item.name]
        if is_dataclass(hint):
            parts[item.name] = from_arrays(
                hint,  # type: ignore[arg-type]  # a class, not an instance
                arrays,
                f"{prefix}{item.name}.",
            )
        else:
            content = arrays[prefix + item.name]
            # A number keeps its precision, which the compiled loops are made for.
            parts[item.name] = content[()] if content.dtype.kind != "U" else str(content)
    return kind(**parts)
