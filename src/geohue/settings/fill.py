"""Settings of the Appendix: labels for pixels without depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from geohue.settings.checks import check_choice

FillRule = Literal["appendix", "watershed"]
FILL_RULES: tuple[FillRule, ...] = get_args(FillRule)


@dataclass(frozen=True, slots=True)
class FillSettings:
    """How pixels without depth get a label.

    Attributes
    ----------
    rule : {"appendix", "watershed"}
        `fill_labels`, or `flood_labels`.

    Raises
    ------
    GeohueError
        For an unknown rule.
    """

    rule: FillRule = "appendix"

    def __post_init__(self) -> None:
        check_choice("fill rule", self.rule, FILL_RULES)
