"""The zero mark going by, and how the marks of a test are told."""

from dataclasses import dataclass


@dataclass(frozen=True)
class IndexPass:
    """The zero mark going by: `turn` as the core counted it, `direction` 1 forward and -1 reverse, `time_s` from the
    start, `closure_error_counts` (0 at the first index, which homes; None when it could not be read before the next
    mark came), `homes` for that one.
    """

    time_s: float
    direction: int
    turn: int
    closure_error_counts: int | None
    homes: bool


def missing_text(missing: list[tuple[int, int]]) -> str:
    """`; missing: turn 3 forward` for turns and directions of marks that did not come, nothing where all came."""
    shown = ", ".join(f"turn {turn} {'forward' if direction > 0 else 'reverse'}" for turn, direction in missing[:6])
    return f"; missing: {shown}{' ...' if len(missing) > 6 else ''}" if missing else ""


def closure_text(errors: list[int | None], largest: int = 0) -> str:
    """`0 counts` where all agree, else each of them; `?` for one that was not read, with the largest of all."""
    if not errors:
        return "no zero mark came back"
    if len(set(errors)) == 1 and errors[0] is not None:
        text = f"{errors[0]} counts"
    else:
        shown = " ".join("?" if error is None else str(error) for error in errors[:30])
        text = f"{shown}{' ...' if len(errors) > 30 else ''} counts"
    return text if largest in (0, *errors) else f"{text}, {largest} at most"
