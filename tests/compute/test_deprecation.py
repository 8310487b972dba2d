"""Names that go: they still work, and say so where they are used."""

from __future__ import annotations

import pytest

from geohue.compute.deprecation import deprecated, renamed_argument
from geohue.errors import GeohueError


@deprecated(since="1.1", gone="1.3", instead="new()")
def old() -> int:
    """An old function."""
    return 3


@renamed_argument("n", "count", since="1.1", gone="1.3")
def double(count: int = 1) -> int:
    """Twice as many."""
    return 2 * count


def test_an_old_function_warns_at_the_line_that_calls_it() -> None:
    with pytest.warns(FutureWarning, match=r"old\(\) goes in geohue 1.3") as seen:
        assert old() == 3
    assert seen[0].filename == __file__
    assert old.__doc__ == "An old function."


def test_an_old_argument_is_passed_on_with_a_warning() -> None:
    with pytest.warns(FutureWarning, match="count=") as seen:
        assert double(n=4) == 8  # type: ignore[call-arg]
    assert seen[0].filename == __file__


def test_the_new_argument_does_not_warn() -> None:
    assert double(count=4) == double(4) == 8


def test_both_names_are_an_error() -> None:
    with pytest.raises(GeohueError, match="leave out n"):
        double(n=1, count=2)  # type: ignore[call-arg]
