"""Initial value problems by name: ``problem("kepler", eccentricity="3/5")``.

Each problem is built by a function of the module named in the table below, or by a table of
``named.toml``; the function's arguments are the problem's parameters. Nothing is imported before it
is requested.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from ..errors import DataError, UsageError
from ..system.arguments import no_such, shown, unknown_key
from .model import Problem
from .table import OWN, from_table, table_of

__all__ = ["Problem", "about", "from_path", "names", "problem"]

_MODULES = {
    "small": ("dahlquist", "henon-heiles"),
    "nbody": ("arenstorf", "n-body"),
    "chains": ("fput", "fput-stiff", "nonseparable-chain", "toda"),
    "extreme": (
        *("linear-field", "long-chain", "zero-field"),
        *("fault-jacobian", "fault-jacobian-nan", "fault-raises", "fault-shape"),
    ),
    "named": (
        *("double-pendulum", "harmonic-oscillator", "kepler", "kepler-sundman", "pendulum"),
        *("lotka-volterra", "lotka-volterra-logarithmic", "rigid-body", "scaled-kepler"),
        *("figure-eight", "outer-solar-system", "pleiades", "pythagorean"),
        *("hires", "kaps", "oregonator", "prothero-robinson", "robertson", "van-der-pol"),
        *("blow-up", "fault-infinity", "fault-nan", "stiff-spring-pendulum"),
        *("charge-in-gauge", "dipole-charge", "discrete-schroedinger", "elastic-pendulum"),
        *("frame-dragging", "heavy-top", "hyperbolic-oscillator", "magnetic-trap"),
        *("post-newtonian-binary", "quartic-shear", "restricted-three-body"),
        *("hill-moon", "magnetic-bottle", "penning-trap", "relativistic-charge"),
        *("rotating-three-body", "schwarzschild-orbit", "shear", "swinging-atwood", "uneven-plane"),
    ),
    "quadratic": ("point-vortices", "skew-quadratic"),
}
_HOME = {name: module for module, listed in _MODULES.items() for name in listed}


def names() -> list[str]:
    """Return names of the problems, sorted."""
    return sorted(_HOME)


def problem(name: str, **parameters: object) -> Problem:
    """Return a problem by name, with its default parameters unless given, or one of a file.

    Parameters
    ----------
    name : str
        One of :func:`names`, or a TOML file, see :func:`from_path`.
    **parameters : object
        Numbers, or strings such as ``"3/5"``; a float means its exact binary value.

    Raises
    ------
    UsageError
        For an unknown name or parameter, or a value out of range.
    """
    if isinstance(name, str) and name.endswith(".toml") and not parameters:
        return from_path(name)
    build = _builder(name)
    known = inspect.signature(build).parameters
    if fault := unknown_key(parameters, known, f" for the problem {name!r}", "parameter"):
        raise UsageError(fault)
    try:
        return build(**parameters)
    except ArithmeticError:  # each value is in range, a product or quotient of them is not
        given = ", ".join(f"{key} = {value}" for key, value in parameters.items())
        raise UsageError(
            f"the problem {name!r} leaves the range of double precision at {given}; "
            f"give parameters nearer to 1"
        ) from None


def from_path(path: str | Path) -> Problem:
    """Read the problem of a TOML file: a table with ``H``, ``f``, ``file`` or a shipped ``name``.

    Raises
    ------
    DataError
        One sentence on what is wrong, with the name of the file.
    """
    path = Path(path)
    table = table_of(path)
    try:
        if "name" in table and not set(OWN) & set(table):
            return problem(str(table["name"]), **{k: v for k, v in table.items() if k != "name"})
        return from_table({"name": path.stem, **table}, path.resolve().parent)
    except UsageError as error:
        raise DataError(f"{path.name}: {error}") from None


def about(name: str) -> str:
    """Return one line on a problem, from the docstring of the function that builds it."""
    return (inspect.getdoc(_builder(name)) or "").partition("\n")[0]


def _builder(name: str) -> Callable[..., Problem]:
    if not isinstance(name, str) or name not in _HOME:
        hint = "`glmref problems` lists them, and so does glmref.problems.names()"
        if shown(name, str).endswith(".py"):
            hint = 'write file = "FILE.py:FUNCTION" into a TOML file, and give that file'
        raise no_such("problem", name, _HOME, hint)
    module = import_module(f".{_HOME[name]}", __name__)
    if _HOME[name] == "named":
        return module.builder(name)
    return getattr(module, name.replace("-", "_"))
