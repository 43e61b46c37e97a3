"""The claims a method file can make, one :class:`ClaimSpec` each.

What the package knows of a claim apart from its proof follows from this table: the keys a file may
have and their kinds of values (:mod:`.keys`, :mod:`.reader`), their order in a file
(:mod:`.canonical`), the rule of the kernel that finds what is true (:mod:`glmref.prove.kernel`),
and the JSON Schema, which ``python -m tools.method_schema`` writes. Which methods can make it is
said by the judge (:mod:`glmref.judge.statements`), when it is true in ``data/README.md``. Modules
that need one particular claim take its key from here, for example ``ZERO_STABLE.key``.

Only the standard library is used.
"""

from __future__ import annotations

import builtins
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

#: The name of the weights of the solution among those of the rows.
SOLUTION = "b"
#: The size of a residual in a claim.
SIZE = re.compile("[1-9][.][0-9]e-[1-9][0-9]{0,2}", re.ASCII)


@dataclass(frozen=True)
class ClaimSpec:
    """What a claim is.

    Parameters
    ----------
    key : str
        The key under ``claims`` of a method file.
    type : type
        Of the value: ``int`` for an order, ``dict`` for orders by the names of embedded rows (or
        for what :attr:`sized` says), ``bool``, ``list`` of expressions, or ``str`` for one.
    """

    key: str
    type: builtins.type

    @property
    def sized(self) -> bool:
        """Whether the orders by name come with the size of a residual: ``[10, "2.7e-85"]``."""
        return self.key == "order-to-digits"


#: Every claim by its key, in the order of canonical files.
CLAIMS: dict[str, ClaimSpec] = {}


def _claim(key: str, kind: builtins.type) -> ClaimSpec:
    """Enter a claim into the table and return it."""
    CLAIMS[key] = ClaimSpec(key, kind)
    return CLAIMS[key]


ORDER = _claim("order", int)
ORDER_IDENTITY = _claim("order-identity", int)
EFFECTIVE_ORDER = _claim("effective-order", int)
NYSTROM_ORDER = _claim("nystrom-order", int)
STAGE_ORDER = _claim("stage-order", int)
STARTING_ORDER = _claim("starting-order", int)
NYSTROM_STARTING_ORDER = _claim("nystrom-starting-order", int)
ERROR_CONSTANT = _claim("error-constant", str)
ABSCISSAE = _claim("abscissae", list)
PRECONSISTENT = _claim("preconsistent", bool)
CONSISTENT = _claim("consistent", bool)
ZERO_STABLE = _claim("zero-stable", bool)
EXPLICIT = _claim("explicit", bool)
SYMPLECTIC = _claim("symplectic", bool)
G_SYMPLECTIC = _claim("g-symplectic", bool)
CONJUGATE_SYMPLECTIC = _claim("conjugate-symplectic", bool)
CONJUGATE_SYMPLECTIC_ORDER = _claim("conjugate-symplectic-order", int)
HAMILTONIAN_TO_ORDER = _claim("hamiltonian-to-order", int)
ENERGY_ORDER = _claim("energy-order", int)
SYMMETRIC = _claim("symmetric", bool)
PARASITISM_FREE = _claim("parasitism-free", bool)
REDUCIBLE = _claim("reducible", bool)
GROWTH = _claim("growth", list)
SECOND_ORDER_GROWTH = _claim("second-order-growth", list)
A_STABLE = _claim("a-stable", bool)
L_STABLE = _claim("l-stable", bool)
FINISHING_ORDER = _claim("finishing-order", int)
SYMMETRIC_REDUCED = _claim("symmetric-reduced", bool)
EMBEDDED_ORDER = _claim("embedded-order", dict)
ORDER_TO_DIGITS = _claim("order-to-digits", dict)
EMBEDDED_DIFFERENCE = _claim("embedded-difference", bool)
ROW_SUMS = _claim("row-sums", bool)
DENSE_ORDER = _claim("dense-order", int)
DENSE_END = _claim("dense-end", bool)
W_ORDER = _claim("w-order", int)


def meant_order(claims: Mapping[str, Any]) -> int | None:
    """Return the order that a method is known by: on second-order systems where that is claimed."""
    return claims.get(NYSTROM_ORDER.key, stated_orders(claims).get(SOLUTION))


def stated_orders(claims: Mapping[str, Any]) -> dict[str, int]:
    """Return the orders that a file states, exactly or of rounded coefficients, by name of weights.

    ``b`` is the solution (:data:`SOLUTION`), the others are rows of ``embedded``, which have other
    names; what is not stated is left out.
    """
    found = {name: order for name, (order, _) in claims.get(ORDER_TO_DIGITS.key, {}).items()}
    found |= claims.get(EMBEDDED_ORDER.key, {})
    return found if ORDER.key not in claims else {**found, SOLUTION: claims[ORDER.key]}


@dataclass(frozen=True)
class Said:
    """One thing that the owner of a tableau says of it."""

    #: The key of the claim, or ``part`` for the order of a part.
    claim: str
    #: At least; of a difference 0.
    order: int
    #: Number of the row or of the part, from 1.
    number: int = 0


class PlainClaims(dict[str, Any]):
    """Claims of a plain document."""

    said: tuple[Said, ...] = ()  #: The orders, each the least that the method has.
    name: str = ""  #: What the owner calls the method.
    #: Of an additive method where each part is evaluated in time, as it is given.
    times: tuple[Any, ...] | None = None
