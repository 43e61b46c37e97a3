"""The claims a method file can make, one :class:`ClaimSpec` each.

What the package knows of a claim apart from its proof follows from this table: the keys a file may
have and their kinds of values (:mod:`.keys`, :mod:`.reader`), their order in a file
(:mod:`.canonical`), which methods can make it (:mod:`glmref.prove.verifier`), the rule of the
kernel that finds what is true (:mod:`glmref.prove.kernel`), and the JSON Schema and the table of
``data/README.md``, which ``python -m tools.method_schema`` writes. Modules that need one particular
claim take its key from here, for example ``ZERO_STABLE.key``.

Only the standard library is used.
"""

from __future__ import annotations

import builtins
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

#: The name of the weights of the solution among those of the rows.
SOLUTION = "b"

Kind = Literal["any", "single", "partitioned", "rosenbrock"]
ANY: Kind = "any"
SINGLE: Kind = "single"
PARTITIONED: Kind = "partitioned"
ROSENBROCK: Kind = "rosenbrock"


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
    applies_to : {"any", "single", "partitioned", "rosenbrock"}
        The methods for which the claim has a meaning.
    schema : Mapping
        JSON Schema of the value, within the schema of ``glmref-method-1``.
    sentence : str
        When the claim is true, as Markdown for ``data/README.md``.
    """

    key: str
    type: builtins.type
    applies_to: Kind
    schema: Mapping[str, Any]
    sentence: str

    @property
    def sized(self) -> bool:
        """Whether the orders by name come with the size of a residual: ``[10, "2.7e-85"]``."""
        return self.key == "order-to-digits"

    @property
    def additive(self) -> bool:
        """Whether a method for a sum of right-hand sides can make this claim."""
        return self.key in _OF_SUMS

    @property
    def rosenbrock(self) -> bool:
        """Whether a Rosenbrock method can make this claim."""
        return self.key in _OF_ROSENBROCK

    @property
    def nystrom(self) -> bool:
        """Whether a Nystrom method can make this claim, which other pairs cannot."""
        return self.key == "row-sums"

    def has_meaning(self, *, pair: bool) -> bool:
        """Return whether a partitioned method (``pair``) or a single one can make this claim."""
        return self.applies_to in (ANY, PARTITIONED if pair else SINGLE)


#: The size of a residual in a claim.
SIZE = re.compile("[1-9][.][0-9]e-[1-9][0-9]{0,2}", re.ASCII)

_ORDER = {"$ref": "#/$defs/order"}
_TRUTH = {"type": "boolean"}
_ORDERS = {
    "type": "object",
    "minProperties": 1,
    "additionalProperties": {"$ref": "#/$defs/order"},
}
_SIZED_ORDERS = {
    "type": "object",
    "minProperties": 1,
    "additionalProperties": {
        "type": "array",
        "minItems": 2,
        "maxItems": 2,
        "prefixItems": [
            {"$ref": "#/$defs/order"},
            {"type": "string", "pattern": f"^{SIZE.pattern}$"},
        ],
        "items": False,
    },
}
_NUMBERS = {"type": "array", "maxItems": 200, "items": {"$ref": "#/$defs/expression"}}

ORDER = ClaimSpec(
    "order",
    int,
    ANY,
    _ORDER,
    (
        "largest p such that a step from the starting values of the exact solution is right "
        "to O(h^{p+1}). Methods that carry one value start from the solution itself; for the "
        "others some starting method must exist. Trees are compared through order 12 "
        "(separable pairs 9, other pairs 8; where the stages of a separable pair are the "
        "solution, those without branches through 20): where none fails there, the order is at "
        "least that and the claim stays open"
    ),
)
ORDER_IDENTITY = ClaimSpec(
    "order-identity",
    int,
    ANY,
    _ORDER,
    (
        "the same with the value that carries the solution, the first k with u_k not 0, "
        "divided by u_k, equal to it, so that no finishing method is needed"
    ),
)
EFFECTIVE_ORDER = ClaimSpec(
    "effective-order",
    int,
    ANY,
    _ORDER,
    (
        "the same with any start, for methods that carry one value: the order between a start "
        "and a finish"
    ),
)
NYSTROM_ORDER = ClaimSpec(
    "nystrom-order",
    int,
    PARTITIONED,
    _ORDER,
    (
        "pairs: `order-identity` on second-order systems q' = M^{-1} p, p' = k(q), or k(q, p) "
        "where the pair is not separable: trees in which a vertex f has two children or more, "
        "or a child f, do not count; where the stages Q are the solution itself, as in "
        "multistep methods, the trees without branches decide, through order 20"
    ),
)
STAGE_ORDER = ClaimSpec(
    "stage-order",
    int,
    ANY,
    _ORDER,
    (
        "largest q such that every stage is the solution at its abscissa to O(h^{q+1}), and q "
        "is not above the order. It is 0 where a stage has two abscissae: c differs from A 1, or "
        "the parts of an additive method disagree"
    ),
)
STARTING_ORDER = ClaimSpec(
    "starting-order",
    int,
    ANY,
    _ORDER,
    (
        "the starting method of the file agrees with the series that the method asks for on "
        "all trees of that order; pairs without `starting`: the start (y0, 0, ..) does"
    ),
)
NYSTROM_STARTING_ORDER = ClaimSpec(
    "nystrom-starting-order",
    int,
    PARTITIONED,
    _ORDER,
    "pairs: the same on second-order systems, as in `nystrom-order`",
)
ERROR_CONSTANT = ClaimSpec(
    "error-constant",
    str,
    SINGLE,
    {"$ref": "#/$defs/expression"},
    (
        "C in the local error C h^{p+1} y^{(p+1)} of a multistep method for y' = g(x): "
        "C_{p+1} / sigma(1), computed from `alpha` and `beta`, whatever values are carried; "
        "BDF with k steps has -1/(k + 1). Classes `lmm` and `one-leg` only: for others it "
        "depends on which value is called the solution"
    ),
)
ABSCISSAE = ClaimSpec(
    "abscissae",
    list,
    SINGLE,
    {"$ref": "#/$defs/vector"},
    (
        "c = A 1 + U v, v of `consistent` with v_k = 0 at the first k with u_k not 0; of an "
        "additive method the c of each part, one part after another"
    ),
)
PRECONSISTENT = ClaimSpec(
    "preconsistent",
    bool,
    ANY,
    _TRUTH,
    "V u = u and U u = 1 for some u",
)
CONSISTENT = ClaimSpec(
    "consistent",
    bool,
    ANY,
    _TRUTH,
    "B 1 + V v = u + v for some v",
)
ZERO_STABLE = ClaimSpec(
    "zero-stable",
    bool,
    ANY,
    _TRUTH,
    "the powers of V are bounded",
)
EXPLICIT = ClaimSpec(
    "explicit",
    bool,
    ANY,
    _TRUTH,
    (
        "the stages have an order in which each needs earlier ones only. Where f and k are "
        "evaluated at the same stages (pairs that are not separable), stage i needs stage j "
        "if A or A^ has an entry there"
    ),
)
SYMPLECTIC = ClaimSpec(
    "symplectic",
    bool,
    ANY,
    _TRUTH,
    (
        "methods that carry one value: b_i a_ij + b_j a_ji = b_i b_j; pairs: b_i a^_ij + b^_j "
        "a_ji = b_i b^_j and, for systems that are not separable, b = b^"
    ),
)
G_SYMPLECTIC = ClaimSpec(
    "g-symplectic",
    bool,
    ANY,
    _TRUTH,
    (
        "G = V^* G V, D U = B^* G V, D A + A^* D = B^* G B with the G and D of the file, or "
        "with some G and D where it gives none, and u^* G u is not 0; pairs: V^* G V^ = G, "
        "D_P U^ = B^* G V^, D_Q U = B^^* G^* V, D_P A^ + A^* D_Q = B^* G B^"
    ),
)
CONJUGATE_SYMPLECTIC = ClaimSpec(
    "conjugate-symplectic",
    bool,
    SINGLE,
    _TRUTH,
    (
        "the underlying one-step method is conjugate to a symplectic one, to every order; it is "
        "the map Phi with M eta = eta Phi for the step M and some series eta, 1 being a simple "
        "eigenvalue of V, and its outputs, w eta = y (docs/modified.md)"
    ),
)
CONJUGATE_SYMPLECTIC_ORDER = ClaimSpec(
    "conjugate-symplectic-order",
    int,
    SINGLE,
    _ORDER,
    (
        "largest n such that the modified field of some chi^{-1} Phi chi is Hamiltonian through "
        "the trees of order n; trees are compared through order 8"
    ),
)
HAMILTONIAN_TO_ORDER = ClaimSpec(
    "hamiltonian-to-order",
    int,
    SINGLE,
    _ORDER,
    "the same of Phi itself, which takes one output to the next",
)
ENERGY_ORDER = ClaimSpec(
    "energy-order",
    int,
    SINGLE,
    _ORDER,
    "largest n such that H(Phi(y)) - H(y) has no terms through h^n for every H; as above",
)
SYMMETRIC = ClaimSpec(
    "symmetric",
    bool,
    ANY,
    _TRUTH,
    (
        "L^2 = I, L V^{-1} L = V, B = V L B P, U = P U L V, A + P A P = U V^{-1} B for some L "
        "and some P with P^2 = I that exchanges stages: of the method of the file as it "
        "stands, V singular is never symmetric"
    ),
)
PARASITISM_FREE = ClaimSpec(
    "parasitism-free",
    bool,
    ANY,
    _TRUTH,
    (
        "V is power-bounded and every growth parameter is 0, where an eigenvalue is multiple "
        "the whole matrix; the principal component leaves a multiple eigenvalue 1 a matrix of "
        "rank 1 and trace 1: a rank above 1, or a nilpotent matrix that is not 0, refutes the "
        "claim, and without a principal component in it the claim is undecided"
    ),
)
REDUCIBLE = ClaimSpec(
    "reducible",
    bool,
    PARTITIONED,
    _TRUTH,
    (
        "pairs: some value carried is never reached from the solution (by V and B) or never "
        "seen by a stage (through U and V), so that a pair with fewer values does the same"
    ),
)
GROWTH = ClaimSpec(
    "growth",
    list,
    ANY,
    _NUMBERS,
    (
        "growth parameters zeta^{-1} w B U v, one for each eigenvalue zeta of V of modulus 1 "
        "other than the principal 1, by increasing argument in [0, 2 pi); w and v are its "
        "eigenvectors, w v = 1. A multiple zeta has a matrix zeta^{-1} W B U N (W N = I), and "
        "its eigenvalues, with multiplicity, are listed in any order; for zeta = 1 the one "
        "that belongs to the principal component, which is 1, is left out. A method that is "
        "not zero-stable has no growth parameters; pairs (only whether they are 0 is "
        "independent of the scaling): zeta^{-1} w B U^ v^ and zeta^{-1} w^ B^ U v at each "
        "eigenvalue that V and V^ share; a pair that is not separable and whose V and V^ share "
        "the simple eigenvalue 1 only: zeta^{-1} w B U v at each eigenvalue of V but 1, and then "
        "zeta^{-1} w^ B^ U^ v^ at each of V^"
    ),
)
SECOND_ORDER_GROWTH = ClaimSpec(
    "second-order-growth",
    list,
    SINGLE,
    _NUMBERS,
    (
        "I1, I3 at each eigenvalue zeta of V of modulus 1 other than 1, by increasing argument in "
        "[0, 2 pi), where 1 and zeta are simple, the growth parameters are 0 and the underlying "
        "one-step method has order 2 or more: I3 is the coefficient of z^3 in log(lambda(z)/zeta), "
        "lambda(z) the eigenvalue of M(z) of `a-stable` that begins in zeta, I1 = zeta^{-1} w B "
        "diag(d) U v, w and v the eigenvectors, w v = 1, and d h^2 f' f the error of the stages "
        "to second order (docs/modified.md)"
    ),
)
A_STABLE = ClaimSpec(
    "a-stable",
    bool,
    SINGLE,
    _TRUTH,
    (
        "M(z) = V + z B (I - z A)^{-1} U is power-bounded for every z with Re z <= 0: it has "
        "no pole there, the imaginary axis included, its eigenvalues lie in the closed disc, "
        "and those of modulus 1 are semisimple, also at z = 0, where M(0) = V"
    ),
)
L_STABLE = ClaimSpec(
    "l-stable",
    bool,
    SINGLE,
    _TRUTH,
    "A-stable, and every eigenvalue of M(z) tends to 0 as z tends to minus infinity",
)
FINISHING_ORDER = ClaimSpec(
    "finishing-order",
    int,
    SINGLE,
    _ORDER,
    (
        "the finishing method of the file undoes the starting method of the file in the "
        "output on all trees of that order"
    ),
)
SYMMETRIC_REDUCED = ClaimSpec(
    "symmetric-reduced",
    bool,
    SINGLE,
    _TRUTH,
    (
        "single methods: `symmetric` for the method without the values that are never reached "
        "or never seen"
    ),
)
EMBEDDED_ORDER = ClaimSpec(
    "embedded-order",
    dict,
    ANY,
    _ORDERS,
    (
        "`order`, of a Nystrom method `nystrom-order`, of the method with the weights of each row "
        "of `embedded` in place of b, by the names of the rows; of class `glm` `order-identity` "
        "of the method with B + u (b - w B) and V + u (v - w V) in place of B and V, u of "
        "`preconsistent` and w the `output`: the values after a step moved so that the row is the "
        "solution"
    ),
)
ORDER_TO_DIGITS = ClaimSpec(
    "order-to-digits",
    dict,
    ANY,
    _SIZED_ORDERS,
    (
        "rounded coefficients, taken as the exact rational numbers that they are, of methods that "
        'carry one value: for `b` and for each row of `embedded` `[p, "e"]`, e the largest '
        "residual of the conditions through order p (of a Nystrom method those of "
        "`nystrom-order`), rounded up to two digits, where a condition of order p + 1 has a "
        "residual above 1000 e"
    ),
)
EMBEDDED_DIFFERENCE = ClaimSpec(
    "embedded-difference",
    bool,
    ANY,
    _TRUTH,
    (
        "the weights of every error estimate, b less the weights of a row of `embedded` or its "
        "`error`, sum to zero. Of class `glm`, w the `output`: with e = w B - b and d = w V - v "
        "d u = 0 and e 1 + d v_1 = 0 for all u and v_1 with V u = u, U u = 1, w u = 1 and "
        "B 1 + V v_1 = u + v_1, of which there are some; without `output` all u must agree in the "
        "first value in which one of them is not 0"
    ),
)
ROW_SUMS = ClaimSpec(
    "row-sums",
    bool,
    SINGLE,
    _TRUTH,
    (
        "c = A 1. Where it fails `order` is that on systems y' = f(t, y), f evaluated at t + c_i "
        "h. Of class `nystrom` A 1 = c^2 / 2, and A' 1 = c where A' is given"
    ),
)
DENSE_ORDER = ClaimSpec(
    "dense-order",
    int,
    SINGLE,
    _ORDER,
    (
        "largest p such that y + h sum b_i(theta) f(Y_i) is y(t + theta h) to O(h^{p+1}) for "
        "every theta"
    ),
)
DENSE_END = ClaimSpec(
    "dense-end",
    bool,
    SINGLE,
    _TRUTH,
    "b(1) = b: the dense output ends in the solution",
)
W_ORDER = ClaimSpec(
    "w-order",
    int,
    ROSENBROCK,
    _ORDER,
    "Rosenbrock methods: `order` with any matrix in the place of the Jacobian",
)

#: Every claim by its key, in the order of canonical files.
CLAIMS: Mapping[str, ClaimSpec] = {
    spec.key: spec
    for spec in (
        ORDER,
        ORDER_IDENTITY,
        EFFECTIVE_ORDER,
        NYSTROM_ORDER,
        STAGE_ORDER,
        STARTING_ORDER,
        NYSTROM_STARTING_ORDER,
        ERROR_CONSTANT,
        ABSCISSAE,
        PRECONSISTENT,
        CONSISTENT,
        ZERO_STABLE,
        EXPLICIT,
        SYMPLECTIC,
        G_SYMPLECTIC,
        CONJUGATE_SYMPLECTIC,
        CONJUGATE_SYMPLECTIC_ORDER,
        HAMILTONIAN_TO_ORDER,
        ENERGY_ORDER,
        SYMMETRIC,
        PARASITISM_FREE,
        REDUCIBLE,
        GROWTH,
        SECOND_ORDER_GROWTH,
        A_STABLE,
        L_STABLE,
        FINISHING_ORDER,
        SYMMETRIC_REDUCED,
        EMBEDDED_ORDER,
        ORDER_TO_DIGITS,
        EMBEDDED_DIFFERENCE,
        ROW_SUMS,
        DENSE_ORDER,
        DENSE_END,
        W_ORDER,
    )
}

#: Claims that an additive method can make: those about its trees, its V and its stages.
_OF_SUMS = frozenset(
    x.key
    for x in (
        ORDER, ORDER_IDENTITY, EFFECTIVE_ORDER, STAGE_ORDER, ABSCISSAE, PRECONSISTENT, CONSISTENT,
        ZERO_STABLE, EXPLICIT, EMBEDDED_ORDER, EMBEDDED_DIFFERENCE, ORDER_TO_DIGITS,
    )
)  # fmt: skip
#: Claims that a Rosenbrock method can make; A- and L-stability are those of its linear form.
_OF_ROSENBROCK = frozenset(
    x.key
    for x in (
        ORDER, W_ORDER, A_STABLE, L_STABLE, EMBEDDED_ORDER, EMBEDDED_DIFFERENCE, ORDER_TO_DIGITS,
    )
)  # fmt: skip


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
