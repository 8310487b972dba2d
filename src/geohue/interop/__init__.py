"""Things of other libraries as scenes, and segments as things of the same kind.

Nothing is imported: a thing is known by the attributes it has.
"""

from __future__ import annotations

from geohue.interop.give import labelled
from geohue.interop.take import as_scene

__all__ = ["as_scene", "labelled"]
