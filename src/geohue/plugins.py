"""What can be added by name from outside: by a package's entry points, or by a call in a script.

A package names what it brings in its ``pyproject.toml``, and nothing of it is imported before it
is used::

    [project.entry-points."geohue.methods"]
    blobs = "my_package.blobs:METHOD"

The groups are ``geohue.methods``, ``.cues``, ``.voters``, ``.presets``, ``.clouds``, ``.layouts``
and ``.sensors``. See docs/extending.md.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from multiprocessing import parent_process
from threading import RLock
from types import MappingProxyType
from typing import Any, Generic, TypeVar

from geohue.errors import GeohueError, GeohueWarning

Value = TypeVar("Value")

KINDS = ("methods", "cues", "voters", "presets", "clouds", "layouts", "sensors")
"""What there are registries of; the entry points of each are in the group ``geohue.KIND``."""


@cache
def plugins_of(kind: str) -> dict[str, EntryPoint]:
    """Return the entry points of a kind by their names; nothing is imported.

    Examples
    --------
    >>> isinstance(plugins_of("methods"), dict)
    True
    """
    found = sorted(entry_points(group=f"geohue.{kind}"), key=lambda entry: entry.value)
    return {entry.name: entry for entry in found}


class Registry(Mapping[str, Value], Generic[Value]):
    """Things of one kind by their names: ours, those added by a call, and those of plugins.

    A plugin is imported when its name is looked up, or when all are. One that cannot be is left
    out, with one warning.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    own : mapping
        What geohue has itself.
    is_one : callable
        Whether a value is one of the kind.
    expected : str
        What such a value is, for errors.

    Examples
    --------
    >>> colors = Registry("cues", {"red": 1}, lambda value: isinstance(value, int), "a number")
    >>> colors.add("green", 2)
    >>> list(colors), colors["green"], "blue" in colors
    (['red', 'green'], 2, False)
    >>> colors.add("red", 3)
    Traceback (most recent call last):
    geohue.errors.GeohueError: cues 'red': the name is taken or empty
    >>> colors.add("blue", "3")
    Traceback (most recent call last):
    geohue.errors.GeohueError: cues 'blue' is '3': expected a number
    """

    def __init__(
        self,
        kind: str,
        own: Mapping[str, Value],
        is_one: Callable[[Any], bool],
        expected: str,
    ) -> None:
        self.kind = kind
        self.own: Mapping[str, Value] = MappingProxyType(dict(own))
        self._is_one, self._expected = is_one, expected
        self._added: dict[str, Value] = {}
        self._loaded: dict[str, Value | None] = {}  # None for one that cannot be used
        self._turn = RLock()

    def add(self, name: str, value: Value) -> None:
        """Add a value in this process; raises `GeohueError` if the name or the value is no good."""
        if not name or name in self.own or name in self._added:
            raise GeohueError(f"{self.kind} {name!r}: the name is taken or empty")
        self._check(name, value)
        self._added[name] = value

    def remove(self, name: str) -> None:
        """Forget a value that was added."""
        self._added.pop(name, None)

    def names(self) -> tuple[str, ...]:
        """Return all names without importing a plugin: some may turn out to be of no use."""
        return tuple(dict.fromkeys((*self.own, *self._added, *plugins_of(self.kind))))

    def foreign(self) -> tuple[str, ...]:
        """Return the names of what is not geohue's own and can be used."""
        return tuple(name for name in self if name not in self.own)

    def __getitem__(self, name: str) -> Value:
        for known in (self.own, self._added):
            if name in known:
                return known[name]
        value = self._plugin(name)
        if value is None:
            raise KeyError(name)
        return value

    def __iter__(self) -> Iterator[str]:
        for name in self.names():
            if name in self.own or name in self._added or self._plugin(name) is not None:
                yield name

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _plugin(self, name: object) -> Value | None:
        """Return what a plugin brings; None, after a warning, if it cannot be used."""
        entry = plugins_of(self.kind).get(name) if isinstance(name, str) else None
        if entry is None:
            return None
        with self._turn:
            if entry.name not in self._loaded:
                self._loaded[entry.name] = self._load(entry)
        return self._loaded[entry.name]

    def _load(self, entry: EntryPoint) -> Value | None:
        try:
            value: Value = entry.load()
            self._check(entry.name, value)
        except Exception as error:  # whatever there is in somebody else's code
            if parent_process() is None:  # a worker is not to say again what its parent has said
                text = " ".join(f"{type(error).__name__}: {error}".split())
                owner = entry.dist.name if entry.dist else entry.value
                warnings.warn(
                    f"plugin {entry.name!r} of {owner} ({self.kind}) is left out: {text}; update "
                    f"or remove {owner}",
                    GeohueWarning,
                    stacklevel=2,
                )
            return None
        return value

    def _check(self, name: str, value: Value) -> None:
        if not self._is_one(value):
            raise GeohueError(f"{self.kind} {name!r} is {value!r}: expected {self._expected}")
        named = getattr(value, "name", name)
        if named != name:
            raise GeohueError(f"{self.kind} {name!r} calls itself {named!r}: give it one name")
