"""Problems that a user can solve, in words."""

from __future__ import annotations

from .translate import translated


class Problem(Exception):
    """Something that stops the work; `remedy` says what helps."""

    def __init__(self, what: str, remedy: str = "") -> None:
        self.what, self.remedy = what, remedy
        super().__init__(what + "\n  " + translated("help: {remedy}", remedy=remedy) if remedy else what)


def words(error: BaseException) -> str:
    """Returns what to show for an error: its own words, which have the remedy."""
    return str(error) or type(error).__name__
