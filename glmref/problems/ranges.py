"""Read the parameters of a problem: one sentence for each that is out of range."""

from __future__ import annotations

from ..errors import UsageError
from ..system.arguments import whole
from .formula import Number, exact_number


def number(
    value: object,
    name: str,
    *,
    above: Number | None = None,
    least: Number | None = None,
    below: Number | None = None,
) -> Number:
    """Read a number with above < value, least <= value, value < below.

    Raises
    ------
    UsageError
        Naming the parameter, its range and the value.
    """
    result = exact_number(value, name)
    wrong = (
        (above is not None and not result > above)
        or (least is not None and not result >= least)
        or (below is not None and not result < below)
    )
    if wrong:
        left = f"{above} < " if above is not None else f"{least} <= " if least is not None else ""
        right = f" < {below}" if below is not None else ""
        raise UsageError(f"`{name}` must satisfy {left}{name}{right}, got {value}")
    return result


def count(value: object, name: str, *, least: int = 1, most: int = 10**7) -> int:
    """Read a whole number between ``least`` and ``most``.

    Raises
    ------
    UsageError
        Naming the parameter, its range and the value.
    """
    result = exact_number(value, name)
    return whole(name, int(result) if result == int(result) else value, least, most)
