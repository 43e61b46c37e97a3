"""``export(method, to=...)``: a method as the source file or the table of somebody else."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

from ..errors import UsageError
from ..method import GLM, PartitionedGLM
from .numbers import check_digits

__all__ = ["TARGETS", "export"]

_LANGUAGES = ("c", "c++", "fortran", "julia", "rust", "python", "jax")
#: What a method can be exported to: steppers, then tables.
TARGETS = (
    *_LANGUAGES,
    *("latex", "sundials", "petsc", "diffrax", "ordinarydiffeq", "rungekutta.jl", "json", "csv"),
)


def export(method: GLM | PartitionedGLM | str | Path, *, to: str, digits: int | None = None) -> str:
    """Return a method as a source file or as a table of another package.

    Parameters
    ----------
        method: a method, its name, or the path of its file.
        to: one of :data:`TARGETS`. The languages give a stepper without dependencies, with start
            and finish; pairs are stepped on separable systems q' = dq(p), p' = dp(q).
        digits: significant digits of decimals (in JSON and CSV digits after the point). By default
            steppers have the shortest decimals that give the nearest doubles, tables 34 digits
            where a number is no quotient, and JSON, CSV and LaTeX exact expressions.

    Returns
    -------
        The text of the file.

    Raises
    ------
        UsageError: for an unknown target, and for a method that the target cannot hold.
        DataError: for a file that is not what it must be.
    """
    if to not in TARGETS:
        near = get_close_matches(str(to), TARGETS, n=1)
        hint = f"did you mean {near[0]}?" if near else f"one of {', '.join(TARGETS)}"
        raise UsageError(f"there is no export to {to!r}; {hint}")
    check_digits(digits)
    if isinstance(method, str | Path):
        from ..catalogue.lookup import load

        method = load(method)
    if not isinstance(method, GLM | PartitionedGLM):
        raise UsageError(f"`method` must be a method or its name, got {type(method).__name__}")
    if to in _LANGUAGES:
        from .steppers import stepper

        return stepper(method, to, digits)
    from .tables import table

    return table(method, to, digits)
