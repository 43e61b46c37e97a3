"""What is in the shipped files, each read once: from here the cases of a family are chosen.

Tests are collected by every worker before the first one runs; to read the whole catalogue for each
family would take longer than the quick tests of several subpackages.
"""

import json
from collections.abc import Container, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from glmref.catalogue.files import data_root, document, names
from glmref.catalogue.keys import PAIRS
from glmref.catalogue.lookup import load
from glmref.exact.linalg import Matrix, Vector
from glmref.method import GLM
from glmref.method.entries import Entries, as_vector

#: Statements that are false, and true ones with a wrong proof.
HOSTILE: list[dict[str, Any]] = [
    row
    for path in sorted((data_root() / "hostile").glob("*.json"))
    for row in json.loads(path.read_text(encoding="utf-8"))["rows"]
]


@cache
def shipped(name: str) -> Mapping[str, Any]:
    """Return the members of a shipped file, to be read and not to be changed."""
    return MappingProxyType(document(name))


def claiming(*keys: str, without: Container[str] = PAIRS) -> list[str]:
    """Return the shipped methods, but for some classes, that claim one of these properties."""
    return [
        name
        for name in names("methods")
        if any(shipped(name)["claims"].get(key) is True for key in keys)
        and shipped(name)["class"] not in without
    ]


def tableau(name: str) -> tuple[Matrix, Vector]:
    """Return A and b of a shipped Runge-Kutta method."""
    method = load(name)
    assert isinstance(method, GLM)
    return method.A, method.B[0]


def multistep(name: str) -> tuple[Entries, Entries]:
    """Return alpha and beta of a shipped multistep method."""
    return shipped(name)["alpha"], shipped(name)["beta"]


def one_leg_twin(alpha: Entries, beta: Entries) -> tuple[Vector, Vector]:
    """One-leg twin of a multistep method: scaled so that ``sum beta_m = 1``."""
    a, b = as_vector(alpha, "alpha"), as_vector(beta, "beta")
    total = sum(b, 0 * b[0])
    return tuple(x / total for x in a), tuple(x / total for x in b)
