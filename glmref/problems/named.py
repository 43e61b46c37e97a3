"""Problems that are data, in ``named.toml``: their parameters, and what is computed from them."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any

from .canonical import rational
from .flows import FLOWS
from .formula import Formula, Number
from .from_expressions import equation_entries, hamiltonian_entries
from .loops import QuadraticForm
from .model import Problem
from .nbody import gravity
from .precision import Flow
from .ranges import number

#: What the package says of a problem, and no entry of one.
_BOUNDS = ("above", "least", "below")
_ABOUT = ("about", "held_out", "parameters", *_BOUNDS)


@cache
def tables() -> dict[str, dict[str, Any]]:
    """Return the tables of ``named.toml`` by the name of their problem."""
    return tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))


def builder(name: str) -> Callable[..., Problem]:
    """Return the function that builds a problem; its arguments are the problem's parameters."""
    table = tables()[name]
    defaults = table.get("parameters", {})
    entries = {key: x for key, x in table.items() if key not in _ABOUT}
    bounds = {
        key: {bound: table[bound][key] for bound in _BOUNDS if key in table.get(bound, ())}
        for key in defaults
    }

    def build(**given: object) -> Problem:
        values = {k: number(x, k, **bounds[k]) for k, x in {**defaults, **given}.items()}
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
    parameters = rest["parameters"]
    rest["t_span"] = (0.0, float(_value(rest.pop("t_end"), parameters)))
    if "masses" in rest:
        return gravity(**rest)
    y0 = rest["y0"] = tuple(rest["y0"])
    scales = rest.get("scales", {})
    rest["scales"] = {key: float(_value(x, parameters)) for key, x in scales.items()}
    rest["quadratic"] = {
        name: QuadraticForm({(i, j): _value(x, parameters) for i, j, x in terms}, len(y0))
        for name, terms in rest.get("quadratic", {}).items()
    }
    if "exact" in rest:
        rest["exact"] = Flow(FLOWS[rest["exact"]], parameters)
    if "common" in rest:
        common = tuple((name, text) for name, text in rest.pop("common"))
        key, variables = ("force", ("q",)) if "force" in rest else ("f", ("t", "y"))
        rest[key] = Formula(tuple(rest[key]), common, variables, parameters)
    return Problem(**rest)


def _value(given: Any, parameters: Mapping[str, Number]) -> Number:
    """Return a number, or the value of an expression in the parameters: exact where rational."""
    if not isinstance(given, str):
        return given
    formula = Formula((given,), parameters=parameters, shape=())
    exact = rational(formula)
    return float(formula(0, ())) if exact is None else exact
