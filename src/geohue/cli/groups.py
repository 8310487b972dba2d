"""Options that belong together, said once for all commands that have them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, get_type_hints


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Let each parameter of a command whose type is a dataclass stand for the fields of that class.

    The command line then has an option for each field, in the place of the parameter and in the
    order of the fields; the command gets the dataclass.

    Parameters
    ----------
    command : callable
        A command of typer. Fields of the dataclasses are annotated as its parameters are.

    Returns
    -------
    callable
        What typer takes in its place.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass
    ... class Size:
    ...     width: int
    ...     height: int = 2
    >>> def area(name: str, size: Size) -> None:
    ...     print(name, size.width * size.height)
    >>> list(signature(with_groups(area)).parameters)
    ['name', 'width', 'height']
    >>> with_groups(area)(name="door", width=3, height=4)
    door 12
    """
    hints = get_type_hints(command, include_extras=True)
    hints.pop("return", None)
    groups: dict[str, Any] = {name: kind for name, kind in hints.items() if is_dataclass(kind)}
    parameters: list[Parameter] = []
    for parameter in signature(command).parameters.values():
        kind = groups.get(parameter.name)
        if kind is None:
            annotation = hints[parameter.name]
            parameters.append(parameter.replace(kind=_BY_NAME, annotation=annotation))
        else:
            parameters += _parameters_of(kind)

    @wraps(command)
    def run(**given: Any) -> None:
        for name, kind in groups.items():
            given[name] = kind(**{entry.name: given.pop(entry.name) for entry in fields(kind)})
        command(**given)

    run.__signature__ = Signature(parameters)  # type: ignore[attr-defined]  # as inspect reads it
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run


_BY_NAME = Parameter.KEYWORD_ONLY


def _parameters_of(group: Any) -> list[Parameter]:
    hints = get_type_hints(group, include_extras=True)
    return [
        Parameter(entry.name, _BY_NAME, default=_default(entry), annotation=hints[entry.name])
        for entry in fields(group)
    ]


def _default(entry: Any) -> Any:
    return Parameter.empty if entry.default is MISSING else entry.default
