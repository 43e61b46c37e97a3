"""Problems that are data, in ``named.toml``: only their parameters are read here."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any

from .formula import Formula
from .from_expressions import equation_entries, hamiltonian_entries
from .model import Problem
from .nbody import gravity
from .ranges import number

#: What the package says of a problem, and no entry of one.
_ABOUT = ("about", "held_out", "parameters", "positive")


@cache
def tables() -> dict[str, dict[str, Any]]:
    """Return the tables of ``named.toml`` by the name of their problem."""
    return tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def builder(name: str) -> Callable[..., Problem]:
    """Return the function that builds a problem; its arguments are the problem's parameters."""
    table = tables()[name]
    defaults = table.get("parameters", {})
    entries = {key: x for key, x in table.items() if key not in _ABOUT}
    above = {key: 0 if key in table.get("positive", ()) else None for key in defaults}

    def build(**given: object) -> Problem:
        values = {k: number(x, k, above=above[k]) for k, x in {**defaults, **given}.items()}
        return _made({"name": name, "parameters": values, **entries})

    build.__doc__ = table["about"]
    build.__signature__ = Signature(  # type: ignore[attr-defined]
        [Parameter(key, Parameter.KEYWORD_ONLY, default=x) for key, x in defaults.items()]
    )
    return build


def _made(table: Mapping[str, Any]) -> Problem:
    """Return the problem of a table with values of its parameters."""
    rest: dict[str, Any] = dict(table)
    if "H" in rest:
        return Problem(**hamiltonian_entries(rest.pop("H"), rest.pop("y0"), time=1, **rest))
    if isinstance(rest.get("f"), dict):
        rest["invariants"] = {"energy": rest.pop("hamiltonian")}
        found = equation_entries(rest.pop("f"), rest.pop("y0"), time=1, **rest)
        return Problem(**found, hamiltonian=found["invariants"].pop("energy"))
    rest["t_span"] = (0.0, rest.pop("t_end"))
    if "masses" in rest:
        return gravity(**rest)
    rest["y0"] = tuple(rest["y0"])
    if "common" in rest:
        common = tuple((name, text) for name, text in rest.pop("common"))
        rest["f"] = Formula(tuple(rest["f"]), common, parameters=rest["parameters"])
    return Problem(**rest)
