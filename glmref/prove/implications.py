"""What an enclosure implies: the table of implications, each with the hypotheses that are checked.

A file with an ``enclosure`` names as many equations as it has unknowns; the interval test proves
that they have exactly one root within the digits (:func:`~.enclosure.prove`). That the *method* at
this root has a property is another step, and this module is the only place where it is taken:

========================  =========================================================================
claim                     hypotheses, exact statements about the document
========================  =========================================================================
preconsistent             the first row of X (and Y) is 1 for all values of the unknowns; the first
                          rows and columns of V and G are 1, 0, .., 0: then u = e_1
consistent                that; 1 - V regular on the values 2..r; the conditions of order 1 given
g-symplectic              V^T G V = G: holds for all values of the unknowns (sweep form)
symplectic                that, and one value carried in each component
symmetric                 D and X palindromic for all values of the unknowns, up to a sign for each
                          row; E G E = G, E V^-1 E = V
order >= p                preconsistent; symmetric (or a product of flows); the equations give all
                          conditions of the odd orders through p (of all orders)
order, w-order >= p, rows classes rk (c = A 1) and rosenbrock: the equations give every tree through
                          p for the weights of each row, those of b by D(1) (:mod:`.simplifying`)
symplectic, symmetric,    class rk: the equations give B(2s) and C(s), as only the Gauss method has
a-stable, stage-order     them (:mod:`.simplifying`)
order-identity >= p       that, and every principal part below p is an exact zero
explicit                  the equations ``explicit I``
growth = 0                V has r different eigenvalues, and for each of modulus 1 other than 1, as
                          a number, the growth parameter is an equation
stage-order >= q          q = 1; or symmetric and the equations ``defect`` for half of the stages
abscissae                 each is fixed by an equation, by symmetry, or is the middle
starting-order >= q       the interval test on the conditions of the start itself; or, for a start
                          of zeros, every value zero by an equation ``start`` or by parity
finishing-order >= q      the interval test on the conditions of the finish, or it is the inverse
                          of the start for all values of the digits
========================  =========================================================================

Of two components every hypothesis is that of both. The theorems are in
:mod:`glmref.method.sweep` and :mod:`.equations`. There is no implication for claims that fail, and
none for upper bounds: those are proved by balls that exclude zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ..catalogue.claims import (
    A_STABLE,
    CONJUGATE_SYMPLECTIC,
    CONSISTENT,
    EFFECTIVE_ORDER,
    EMBEDDED_DIFFERENCE,
    G_SYMPLECTIC,
    NYSTROM_ORDER,
    NYSTROM_STARTING_ORDER,
    ORDER,
    ORDER_IDENTITY,
    PARASITISM_FREE,
    PRECONSISTENT,
    STAGE_ORDER,
    STARTING_ORDER,
    SYMMETRIC,
    SYMPLECTIC,
    W_ORDER,
)
from ..errors import DataError, ExactnessError
from ..exact import Exact, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from .classes import Family, classes
from .enclosure import Enclosure, prove
from .krawczyk import Krawczyk
from .order_conditions import abscissae
from .simplifying import RungeKuttaSystem, prove_runge_kutta
from .starting import Blocks, prove_blocks, target_of
from .system import Affine, SweepSystem

#: Classes whose equations have a meaning.
ENCLOSED = frozenset({"sweep", "pair-sweep", "splitting", "rk", "rosenbrock"})
_SEAL = object()


@dataclass(frozen=True)
class Implied:
    """What is true of the one true method within the digits of a file.

    Attributes
    ----------
    true : Mapping[str, str]
        Claim -> the sentence that says what proves it.
    at_least : Mapping[str, int]
        Claim -> a lower bound of an order.
    growth_zeros : int or None
        How many growth parameters there are, all of them zero; ``None``: unknown.
    abscissae : Sequence[Fraction] or None
        Where all of them are fixed exactly.
    zeros : bool
        Whether entries of A are exact zeros by an equation.
    rows : Mapping[str, int]
        Embedded row -> a lower bound of its order.
    system : SweepSystem or RungeKuttaSystem or None
        The equations of the file; ``None`` where only its start is enclosed.
    root : Krawczyk or None
        Their interval test.
    blocks : Blocks
        The interval tests of start and finish.
    """

    true: Mapping[str, str] = field(default_factory=dict)
    at_least: Mapping[str, int] = field(default_factory=dict)
    growth_zeros: int | None = None
    abscissae: Sequence[Fraction] | None = None
    zeros: bool = False
    rows: Mapping[str, int] = field(default_factory=dict)
    system: SweepSystem | RungeKuttaSystem | None = None
    root: Krawczyk | None = None
    blocks: Blocks = field(default_factory=Blocks)
    seal: object = None

    def __post_init__(self) -> None:
        if self.seal is not _SEAL:
            raise TypeError("only the table of implications makes these")

    def of_row(self, name: str) -> Implied:
        """Return what is true of the method with the weights of an embedded row."""
        return Implied(at_least={ORDER.key: self.rows.get(name, 0)}, seal=_SEAL)


def implied_by(document: Mapping[str, Any] | None, method: Any) -> Implied | None:
    """Return what a file implies about its true method; ``None`` where nothing but balls is known.

    Raises
    ------
    DataError
        When the file asks for more than its equations give.
    ExactnessError
        When the interval test does not find exactly one root near the digits.
    """
    if document is None:
        return None
    if "enclosure" not in document:
        return _by_start(document, method)
    kind = document.get("class")
    if kind not in ENCLOSED:
        raise DataError(
            f"`enclosure` has a meaning in files of class {', '.join(sorted(ENCLOSED))}, and this "
            f"one has class {kind!r}; take it out"
        )
    claims = document.get("claims", {})
    if not any(claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key, NYSTROM_ORDER.key)):
        raise DataError(
            "a file with an `enclosure` must claim an order of at least 1: it says which equations "
            "are needed"
        )
    one_step = kind in ("rk", "rosenbrock")
    return _enclosed_runge_kutta(document) if one_step else _enclosed(document)


def _enclosed_runge_kutta(document: Mapping[str, Any]) -> Implied:
    proved = prove_runge_kutta(document)
    orders = proved.orders
    p, rows = orders[""], orders.keys() - {""}
    true = {PRECONSISTENT.key: "U = V = 1", CONSISTENT.key: "the condition of one vertex"}
    if rows and all(orders[x] for x in rows):  # b and each row sum to 1
        true[EMBEDDED_DIFFERENCE.key] = "the condition of one vertex for each row"
    if document["class"] == "rosenbrock":
        return Implied(
            true, {ORDER.key: p, W_ORDER.key: proved.any_matrix}, rows=orders,
            system=proved.system, root=proved.root, seal=_SEAL,
        )  # fmt: skip
    at_least = {x.key: p for x in (ORDER, ORDER_IDENTITY, EFFECTIVE_ORDER)}
    at_least[STAGE_ORDER.key] = proved.gauss or 1
    if proved.gauss:
        true |= {x.key: "the Gauss method" for x in (
            SYMPLECTIC, G_SYMPLECTIC, CONJUGATE_SYMPLECTIC, SYMMETRIC, A_STABLE)}  # fmt: skip
    return Implied(true, at_least, rows=orders, system=proved.system, root=proved.root, seal=_SEAL)


def _enclosed(document: Mapping[str, Any]) -> Implied:
    system = SweepSystem(document)  # V and G bordered by 1, 0, .., 0; V^T G V = G
    for c, X in system.affine.X.items():
        _check_ones(X[0], f"the first row of `X`{'' if c == 'o' else f' of {c}'}")
    for V, name in zip(system.V.values(), ("V", "V^"), strict=False):
        _check_regular(V, name)
    record = prove(document)  # palindromic, covered, one root: or an error
    true = {
        PRECONSISTENT.key: "the first column of U is the first row of X, which is 1",
        CONSISTENT.key: "the conditions of the trees with one node",
        G_SYMPLECTIC.key: "holds for every value of the unknowns, V^T G V = G",
    }
    if not system.is_partitioned:
        true[CONJUGATE_SYMPLECTIC.key] = "the form of the sweep, and 1 is simple in V"
    if record.signs is not None:
        true[SYMMETRIC.key] = "palindromic for every value of the unknowns"
    if system.is_one_step:
        true[SYMPLECTIC.key] = true[G_SYMPLECTIC.key]
    at_least = _orders(system, record)
    at_least |= record.blocks.orders
    if system.is_partitioned and "starting" not in document:
        for claim, base, family in (
            (STARTING_ORDER.key, ORDER_IDENTITY.key, Family.SEPARABLE),
            (NYSTROM_STARTING_ORDER.key, NYSTROM_ORDER.key, Family.SECOND_ORDER),
        ):
            at_least[claim] = _zero_start(system, at_least.get(base, 0), family)
    zeros = _all_growths(system)
    if zeros is not None:
        true[PARASITISM_FREE.key] = "the growth parameters are equations"
    return Implied(
        true, at_least, zeros, abscissae(system), bool(system.explicit), system=system,
        root=record.root, blocks=record.blocks, seal=_SEAL,
    )  # fmt: skip


def _orders(system: SweepSystem, record: Enclosure) -> dict[str, int]:
    """Return a lower bounds of the orders that the equations give."""
    found: dict[str, int] = {}
    for order, family in system.families:
        identity = system.identity_through(order - 1, family)
        if not system.is_partitioned:  # then the series itself may show it
            identity = record.identity
        if family is not Family.SECOND_ORDER:
            found |= {ORDER.key: order, EFFECTIVE_ORDER.key: order}
            if identity:
                found[ORDER_IDENTITY.key] = order
        if identity and system.is_partitioned:
            found[NYSTROM_ORDER.key] = max(order, found.get(NYSTROM_ORDER.key, 0))
    if not system.is_partitioned:
        found[STAGE_ORDER.key] = min(system.stage_order, record.order)
    return found


def _check_ones(row: Sequence[Any], what: str) -> None:
    for i, x in enumerate(row):
        if not (Affine.of(x) - 1).is_identically_zero():
            raise DataError(
                f"{what} must be 1 for all values of the unknowns, and entry {i + 1} is not: only "
                f"then is the method preconsistent with u = e_1"
            )


def _check_regular(V: Matrix, name: str) -> None:
    """Check 1 - V on the values 2..r: then v of consistency and the starting series exist."""
    r = range(1, len(V))
    rest = tuple(tuple(Exact(int(i == j)) - V[i][j] for j in r) for i in r)
    if rest and linalg.rank(rest) < len(rest):
        raise DataError(
            f"1 - {name} must be regular on the values 2..r; 1 is a multiple eigenvalue"
        )


def _zero_growths(V: Matrix, texts: Sequence[str]) -> int | None:
    """Count the eigenvalues of modulus 1 but 1, if each has an equation; else return ``None``."""
    named: list[Exact] = []
    for text in texts:
        z = parse(text)
        if not isinstance(z, Exact):
            return None
        for x in (z, z.conjugate()):  # V is real: so is the growth parameter of the conjugate
            if all((x - y).is_zero() is False for y in named):
                named.append(x)
    named = [z for z in named if (z - 1).is_zero() is False]
    identity = linalg.identity(len(V))
    for z in named:
        shifted = linalg.sub(V, linalg.scale(z, identity))
        if (z * z.conjugate() - 1).is_zero() is not True or linalg.rank(shifted) != len(V) - 1:
            return None
    # r - 1 different eigenvalues and 1 are all there are, each of them simple
    return len(named) if len(named) == len(V) - 1 else None


def _by_start(document: Mapping[str, Any], method: Any) -> Implied | None:
    """Return a start in decimals of a method that is exact: the interval test on its conditions."""
    if len(method.components) > 1 or not method.is_exact or method.starting is None:
        return None
    if method.starting.is_exact:
        return None
    try:
        blocks = prove_blocks(document, target_of(method))
    except (DataError, ExactnessError):
        return None
    return Implied({}, blocks.orders, blocks=blocks, seal=_SEAL)


def _zero_start(system: SweepSystem, most: int, family: Family) -> int:
    """Return through which order all values but the first are 0, by ``start`` and parity."""
    if system.is_one_step:
        return most
    for n in range(1, most + 1):
        for t in classes(n, 1, family):
            if not all(system.start_vanishes(t, k) for k in range(1, len(system.V[t.colour]))):
                return n - 1
    return most


def _all_growths(system: SweepSystem) -> int | None:
    """Return the number of growth parameters where each of every component has an equation."""
    growths = [e for e in system.equations if e.kind == "growth"]
    counts = [
        _zero_growths(V, [e.value for e in growths if e.colour == c]) for c, V in system.V.items()
    ]
    # an equation names a simple eigenvalue of both V and V^, so equal counts are equal sets
    if counts[0] is None or any(n != counts[0] for n in counts):
        return None
    return len(counts) * counts[0]
