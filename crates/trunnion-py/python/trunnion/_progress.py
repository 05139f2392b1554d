"""Progress of long calls: a callable, or tqdm."""

from __future__ import annotations

# The name alone tells type checkers; the module `typing` would delay every worker.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Callable, Union

    Progress = Union[Callable[[str, int, int], object], Any, None]
    OnPasses = Union[Callable[[int, list[dict[str, Any]]], object], None]
else:
    Progress = OnPasses = object


def adapted(progress: Progress) -> Callable[[str, int, int], object] | None:
    """Returns `progress` as a callable of stage, steps done and steps in all.

    A tqdm bar, or the class itself, is moved to the share of the stage that is done.
    """
    if progress is None:
        return None
    if isinstance(progress, type) and hasattr(progress, "update"):
        progress = progress(total=1, leave=False)
    if hasattr(progress, "update") and hasattr(progress, "n"):
        bar = progress

        def move(stage: str, done: int, total: int) -> None:
            bar.set_description(stage, refresh=False)
            bar.total, bar.n = total, done
            bar.refresh()

        return move
    if callable(progress):
        return progress
    from ._errors import ArgumentError

    kind = type(progress).__name__
    raise ArgumentError(
        f"progress = {kind} is neither a callable nor tqdm\n  help: give a function of (stage, done, total)",
        "progress",
        None,
        kind,
    )


def receiver(on_passes: OnPasses) -> Callable[[int, list[dict[str, Any]]], object] | None:
    """Returns `on_passes`, which has to be a callable."""
    if on_passes is None or callable(on_passes):
        return on_passes
    from ._errors import ArgumentError

    kind = type(on_passes).__name__
    raise ArgumentError(
        f"on_passes = {kind} cannot be called\n  help: give a function of (face, passes)", "on_passes", None, kind
    )
