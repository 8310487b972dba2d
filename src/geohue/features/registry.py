"""The cues by name, and the sets of them that ``cues=`` takes."""

from __future__ import annotations

from geohue.errors import GeohueError
from geohue.features.cue import Cue
from geohue.features.paper import COLOR, GEOMETRY, SECOND_VIEW
from geohue.plugins import Registry

CUES: tuple[str, ...] = ("fusion", "color", "geometry")
"""The paper's choices; cues of one's own are added to one of them: "fusion+normals"."""

_SETS: dict[str, tuple[Cue, ...]] = {
    "fusion": (COLOR, SECOND_VIEW, GEOMETRY),
    "color": (COLOR, SECOND_VIEW),
    "geometry": (GEOMETRY,),
}


def _is_cue(value: object) -> bool:
    return (
        isinstance(value, Cue)
        and "+" not in value.name
        and value.name not in _SETS
        and value.share > 0
    )


_ADDED: Registry[Cue] = Registry(
    "cues", {}, _is_cue, "a Cue with a new name without a plus sign, and a share above 0"
)


def register_cue(cue: Cue) -> Cue:
    """Let ``cues=`` take a cue by its name, added to others with a plus sign.

    Parameters
    ----------
    cue : Cue
        Its name must be new, and have no plus sign.

    Returns
    -------
    Cue
        The cue itself.

    Raises
    ------
    GeohueError
        For a name that is taken or has a plus sign, or a share that is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> from geohue import Scene
    >>> from geohue.features import extract_features
    >>> height = register_cue(Cue("height", "geometry", lambda raw: raw.scene.points[..., 1:2]))
    >>> scene = Scene.from_cloud(np.eye(4, 3), np.eye(4, 3))
    >>> [block.name for block in extract_features(scene, "fusion+height").blocks]
    ['color', 'geometry', 'height']
    >>> remove_cue("height")
    """
    if not cue.share > 0:
        raise GeohueError(f"cue {cue.name!r}: share is {cue.share!r}; expected a number above 0")
    if not cue.name or "+" in cue.name or cue.name in _SETS or cue.name in _ADDED:
        raise GeohueError(f"cue {cue.name!r}: the name is taken, empty or has a plus sign")
    _ADDED.add(cue.name, cue)
    return cue


def remove_cue(name: str) -> None:
    """Forget a cue that was registered."""
    _ADDED.remove(name)


def known_cues() -> tuple[str, ...]:
    """Return what ``cues=`` takes, and can be joined with a plus sign."""
    return (*CUES, *_ADDED)


def cue_columns() -> tuple[str, ...]:
    """Return what "all" cues are in a comparison: the paper's, and each other one beside both.

    Examples
    --------
    >>> cue_columns()[:3]
    ('fusion', 'color', 'geometry')
    """
    return (*CUES, *(f"fusion+{name}" for name in _ADDED))


def cues_named(cues: str) -> tuple[Cue, ...]:
    """Return the cues of a choice, each once: those of colour first, then those of geometry.

    Raises
    ------
    GeohueError
        For an unknown name.

    Examples
    --------
    >>> [cue.name for cue in cues_named("geometry+color")]
    ['color', 'second view', 'geometry']
    """
    found: list[Cue] = []
    for name in cues.split("+") if isinstance(cues, str) else [cues]:
        if name in _SETS:
            found += _SETS[name]
        elif name in _ADDED:
            found.append(_ADDED[name])
        else:
            raise GeohueError(f"cues {cues!r}: choose one of {', '.join(known_cues())}")
    once = dict.fromkeys(found)
    return tuple(sorted(once, key=lambda cue: cue.side))  # "color" before "geometry"; stable


def check_cues(cues: str) -> None:
    """Raise `GeohueError` unless ``cues=`` takes this."""
    cues_named(cues)
