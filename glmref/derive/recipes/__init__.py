"""Named derivations: each reproduces method files, or proves that there is nothing to reproduce.

    from glmref.derive import recipes
    recipes.names()                                        what there is
    recipes.run("order6", {"c2": "1/3", "z": "exp(2*pi*i/3)"}, progress)

A recipe gives a :class:`Derivation`: documents in the format of method files, and statements with
the kind of proof each has. A refusal is a derivation too, without documents.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from importlib import import_module

from ...errors import UsageError
from ...system.arguments import no_such, unknown_key
from .derivation import Derivation, Progress, Statement

__all__ = [
    "Derivation",
    "Progress",
    "Statement",
    "describe",
    "explain",
    "names",
    "options_of",
    "run",
]

#: Recipe -> module of this package that holds it as ``derive(options, progress)``.
_MODULES: Mapping[str, str] = {
    "order6": "order6",
    "two-stage": "two_stage",
    "order4": "order4",
    "thesis-printed": "printed",
    "conjugation6": "conjugation",
    "order8": "order8",
    "yoshida6": "yoshida",
    "pairs": "pairs",
    "multistep": "multistep",
    "general-multistep": "general_multistep",
    "strong-multistep": "strong_multistep",
    "search": "searching",
}


def names() -> list[str]:
    """Return names of the recipes."""
    return list(_MODULES)


def _module(name: str) -> object:
    if name not in _MODULES:
        raise no_such("recipe", name, _MODULES)
    return import_module(f"{__name__}.{_MODULES[name]}")


def describe(name: str) -> str:
    """Return one line on what a recipe derives."""
    return (_module(name).__doc__ or "").partition("\n")[0]


def explain(name: str) -> str:
    """Return what a recipe derives and what its options mean, as plain text."""
    text = (_module(name).__doc__ or "").strip()
    return re.sub(r":\w+:`([^`]*)`", r"\1", text).replace("``", "`")


def options_of(name: str) -> Mapping[str, str]:
    """Return options of a recipe with their defaults."""
    return dict(_module(name).OPTIONS)  # type: ignore[attr-defined]


def run(
    name: str,
    options: Mapping[str, str] | None = None,
    progress: Progress | None = None,
) -> Derivation:
    """Carry out a recipe with the texts of its options; the others keep their defaults.

    Raises
    ------
    UsageError
        For an unknown recipe or option, or a value that cannot be read.
    """
    known = options_of(name)
    if fault := unknown_key(options or {}, known, f" for the recipe {name!r}", "option"):
        raise UsageError(fault)
    derive: Callable[[Mapping[str, str], Progress], Derivation]
    derive = _module(name).derive  # type: ignore[attr-defined]
    return derive({**known, **(options or {})}, progress or _silent)


def _silent(what: str, done: int, total: int) -> None:
    """Report nothing."""
