"""Starting and finishing methods with parity, and the proof that their digits stand for one.

A Runge-Kutta-like start has *parity* when its stages are y0 and pairs that are
exchanged by h -> -h: with the permutation sigma of the pairs, ``A_(sigma i)(sigma j) = -A_ij``
and ``B_(k)(sigma j) = -(L B)_kj``. Then S(-h) = L S(h), as for the starting series of a symmetric
method, so that in eigenvectors of L each value has conditions at the even trees or at the odd
ones only: 25 or 12 of the 37 up to order 6. The first value needs the even trees below the order
only, because the principal part is free at the order itself. A finish with parity, b_(sigma j) =
-b_j, undoes an even series by an even one: 25 conditions.

In a file the decimals of ``starting`` (and of ``finishing``) are the unknowns, as many as
conditions; the other entries are rational. :func:`prove_starting` checks the parity for all
values of the unknowns, and the conditions by the interval test; the starting series of the method
is a parameter, given by balls, and the test holds for every value in them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

from ..catalogue.claims import FINISHING_ORDER, STARTING_ORDER
from ..errors import DataError, ExactnessError
from ..exact import Ball, Exact, ball, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from ..method import GLM
from ..theory.trees import Tree
from .classes import classes
from .enclosure import Enclosure, Krawczyk, Outcome, is_rounding, krawczyk
from .system import Affine, SweepSystem
from .tableau_series import outputs, slopes, stage_order, weights

__all__ = [
    "StartingSystem",
    "Target",
    "enclosed_block",
    "finishing_function",
    "finishing_system",
    "first_value",
    "prove_blocks",
    "prove_finishing",
    "prove_starting",
    "start_is_enclosed",
    "starting_function",
    "starting_system",
    "target_of",
]

Conditions = Callable[[Sequence[Any]], list[Any]]

#: Decimals of a start that are unknowns: entries with fewer places are exact.
_DECIMAL = re.compile(r"\d+\.\d{20,}")
RADIUS = Fraction(1, 10**60)


class StartingSystem:
    """The decimals of a start or finish as unknowns.

    Attributes
    ----------
        unknowns: their values as text, without sign, in order of appearance.
    """

    def __init__(self, entries: Sequence[Sequence[str]]) -> None:
        self.entries = entries
        seen = (x for row in entries for text in row for x in _DECIMAL.findall(text))
        self.unknowns: tuple[str, ...] = tuple(dict.fromkeys(seen))
        self._names = {x: f"x{k}" for k, x in enumerate(self.unknowns)}

    @cached_property
    def _named(self) -> list[list[str | Exact]]:
        """The entries: numbers, and expressions in the names of the unknowns."""

        def named(text: str) -> Any:
            changed, count = _DECIMAL.subn(lambda m: self._names[m[0]], text)
            return changed if count else parse(text)

        return [[named(text) for text in row] for row in self.entries]

    def read(self, values: Sequence[Any]) -> Matrix:
        """Evaluate the entries at values of the unknowns."""
        constants = dict(zip(self._names.values(), values, strict=True))
        return tuple(
            tuple(parse(x, constants=constants) if isinstance(x, str) else x for x in row)
            for row in self._named
        )

    def affine(self) -> list[list[Affine]]:
        """The entries as affine expressions in the unknowns."""
        return self._affine

    @cached_property
    def _affine(self) -> list[list[Affine]]:
        values = [Affine.unknown(x) for x in self._names.values()]
        return [[Affine.of(x) for x in row] for row in self.read(values)]

    def published(self, digits: int) -> list[Ball]:
        """The balls that the digits stand for."""
        return [ball(parse(x, digits=digits)) for x in self.unknowns]


def _pairing(size: int) -> list[int]:
    """Stage 0 is y0; the others come in pairs (1, 2), (3, 4), ..

    Raises
    ------
        DataError: for an even number of stages.
    """
    if size % 2 == 0:
        raise DataError(f"a start with parity has an odd number of stages, got {size}")
    return [0] + [k + 1 if k % 2 else k - 1 for k in range(1, size)]


def _check_parity(system: StartingSystem, size: int, images: Sequence[Sequence[Affine]]) -> None:
    """Check A and the images of the other rows for all values of the unknowns.

    Raises
    ------
        DataError: naming the entry.
    """
    swap, entries = _pairing(size), system.affine()
    for i in range(len(entries)):
        mirrored = entries[swap[i]] if i < size else images[i - size]
        for j in range(size):
            if not (entries[i][swap[j]] + mirrored[j]).is_identically_zero():
                raise DataError(
                    f"no parity: row {i + 1}, column {swap[j] + 1} and its mirror image differ"
                )


def functionals(L: Matrix) -> list[tuple[tuple[Any, ...], int]]:
    """Rows f with f L = +-f, the first being e_1, with the sign."""
    found: list[tuple[tuple[Any, ...], int]] = []
    for sign in (1, -1):
        shifted = linalg.sub(linalg.transpose(L), linalg.scale(sign, linalg.identity(len(L))))
        found += [(row, sign) for row in linalg.nullspace(shifted)]
    first = [x for x in found if not x[0][0].is_zero()]
    if len(found) != len(L) or len(first) != 1 or any(not y.is_zero() for y in first[0][0][1:]):
        raise DataError("the involution L of the method does not keep the first value apart")
    return first + [x for x in found if x is not first[0]]


def _signed_trees(sign: int, order: int, q: int = 1) -> list[Tree]:
    return [t for n in range(1, order + 1) if (n % 2 == 0) == (sign > 0) for t in classes(n, q)]


def starting_conditions(
    B_series: Sequence[Mapping[Tree, Any]],
    zeta: Mapping[Tree, Sequence[Any]],
    L: Matrix,
    order: int,
    q: int,
) -> list[Any]:
    """Start minus starting series, in eigenvectors of L, at the trees that parity leaves.

    Conditions of the first value that hold for all unknowns (a start from y0 itself where the
    principal part is the identity) are left out.
    """
    result = []
    for k, (row, sign) in enumerate(functionals(L)):
        for t in _signed_trees(sign, order - 1 if k == 0 else order, q):
            terms = [s[t] - x for s, x in zip(B_series, zeta[t], strict=True)]
            value = linalg.dot(row, terms)
            if k > 0 or value.is_zero() is not True:
                result.append(value)
    return result


def involution(document: Mapping[str, Any]) -> Matrix:
    """L = V^-1 E of a file of class ``"sweep"``."""
    system = SweepSystem(document)
    signs = system.signs()
    if signs is None:
        raise DataError("only a symmetric method has a start with parity")
    E = linalg.diagonal([Exact(x) for x in signs])
    return linalg.matmul(linalg.inverse(system.V), E)


@dataclass(frozen=True)
class Target:
    """What a start is to agree with.

    Attributes
    ----------
        zeta: starting series of the method through ``order``, exact or balls.
        L: involution of the values, first row and column 1, 0, .., 0. order: of the method.
        stage_order: of the method: zeta respects it.
    """

    zeta: Mapping[Tree, Sequence[Any]]
    L: Matrix
    order: int
    stage_order: int = 1

    @classmethod
    def of(cls, document: Mapping[str, Any], enclosure: Enclosure) -> Target:
        """The target of a file of class ``"sweep"``, from its enclosure."""
        q = SweepSystem(document).stage_order
        return cls(enclosure.series.zeta, involution(document), enclosure.order, q)


def target_of(method: GLM) -> Target:
    """The target of an exact symmetric method whose first value is the solution itself.

    Raises
    ------
        DataError: when the method is not symmetric.
    """
    from ..theory.order import order_of
    from ..theory.symmetry import symmetry

    found, L = order_of(method, principal="identity"), symmetry(method).L
    if L is None or found.eta is None:
        raise DataError("only a symmetric method has a start with parity")
    series = {t: [ball(x) for x in found.eta[t]] for t in found.eta}
    return Target(series, L, found.order)


def starting_system(block: Mapping[str, Any]) -> StartingSystem:
    """The unknowns of a block ``"starting"``."""
    return _system(tuple(map(tuple, [*block["A"], *block["B"]])))


@lru_cache(maxsize=4)
def _system(entries: tuple[tuple[str, ...], ...]) -> StartingSystem:
    """The system of a block, which several proofs of one file ask for."""
    return StartingSystem(entries)


def starting_function(block: Mapping[str, Any], target: Target) -> Conditions:
    """The conditions of a start as a function of its unknowns.

    Where A holds no unknowns and has a stage order, the conditions at classes of trees are
    enough.
    """
    system, size = starting_system(block), len(block["A"])
    stages, q, fixed = StartingSystem(block["A"]), 1, None
    if not stages.unknowns:
        A = stages.read([])
        q = stage_order(A, most=target.stage_order)
        fixed = slopes(A, target.order, parity=True, q=q)

    def conditions(values: Sequence[Any]) -> list[Any]:
        matrix = system.read(values)
        known = fixed or slopes(matrix[:size], target.order, parity=True, q=q)
        found = outputs(matrix[size:], known)
        return starting_conditions(found, target.zeta, target.L, target.order, q)

    return conditions


def prove_starting(block: Mapping[str, Any], target: Target, *, digits: int = 75) -> Krawczyk:
    """Prove that an exact start lies within the digits of a block ``"starting"``.

    Raises
    ------
        DataError: when the start has not the form described above.
        ExactnessError: when the interval test does not succeed.
    """
    size, L, system = len(block["A"]), target.L, starting_system(block)
    if [parse(x) for x in block["u"]] != [Exact(int(k == 0)) for k in range(len(L))]:
        raise DataError("`starting.u` must be 1, 0, .., 0")
    B = system.affine()[size:]
    images = [
        [sum((b[j] * x for b, x in zip(B[1:], row[1:], strict=True)), B[0][j] * row[0])
         for j in range(size)]
        for row in L
    ]  # fmt: skip
    _check_parity(system, size, images)
    return enclosed_block(system, starting_function(block, target), digits, "starting")


def finishing_system(block: Mapping[str, Any]) -> StartingSystem:
    """The unknowns of a block ``"finishing"``."""
    return _system(tuple(map(tuple, [*block["A"], block["b"]])))


def finishing_function(
    block: Mapping[str, Any], base: Mapping[Tree, Any], order: int
) -> Conditions:
    """The conditions of a finish: with ``base``, the first value of the start, it gives y back."""
    system, size = finishing_system(block), len(block["A"])

    def conditions(values: Sequence[Any]) -> list[Any]:
        entries = system.read(values)
        found = weights(entries[:size], entries[size:], order, base, parity=True)[0]
        return [found[t] + base[t] for t in _signed_trees(1, order)]

    return conditions


def first_value(block: Mapping[str, Any], values: Sequence[Any], order: int) -> Mapping[Tree, Any]:
    """Series of the first value of a start, at values of its unknowns."""
    matrix, size = starting_system(block).read(values), len(block["A"])
    return weights(matrix[:size], matrix[size : size + 1], order)[0]


def prove_finishing(
    block: Mapping[str, Any], base: Mapping[Tree, Any], order: int, *, digits: int = 75
) -> Krawczyk:
    """Prove that an exact finish lies within the digits of a block ``"finishing"``.

    Args:
        block: the finish. base: :func:`first_value` of the start, in balls. order: of the method.
        digits: of the file.

    Raises
    ------
        DataError: when the finish has not the form described above.
        ExactnessError: when the interval test does not succeed.
    """
    system = finishing_system(block)
    _check_parity(system, len(block["A"]), [system.affine()[len(block["A"])]])
    return enclosed_block(system, finishing_function(block, base, order), digits, "finishing")


def prove_blocks(document: Mapping[str, Any], target: Target) -> list[str]:
    """Prove the start and the finish of a document; name the claims that follow.

    Blocks without long decimals are exact and are left to exact arithmetic.

    Raises
    ------
        DataError, ExactnessError: see :func:`prove_starting` and :func:`prove_finishing`.
    """
    opening = document.get("starting")
    if opening is None or not starting_system(opening).unknowns:
        return []
    from .inverse_finish import is_inverse

    digits = document.get("digits", 75)
    start = prove_starting(opening, target, digits=digits)
    claims = [STARTING_ORDER.key]
    closing = document.get("finishing")
    if closing is not None and is_inverse(opening, closing):
        claims.append(FINISHING_ORDER.key)
    elif closing is not None and finishing_system(closing).unknowns:
        base = first_value(opening, start.box, target.order)
        prove_finishing(closing, base, target.order, digits=digits)
        claims.append(FINISHING_ORDER.key)
    return claims


def start_is_enclosed(method: GLM) -> bool:
    """Whether the decimal start (and finish) of a file with exact coefficients can be proved."""
    if method.document is None:
        return False
    try:
        return bool(prove_blocks(method.document, target_of(method)))
    except (DataError, ExactnessError):
        return False


def enclosed_block(
    system: StartingSystem, conditions: Conditions, digits: int, key: str
) -> Krawczyk:
    """Prove that one exact block lies near the digits of a file, and that these are its rounding.

    Args:
        system: unknowns of the block. conditions: what they must make vanish.
        digits: behind the point. key: name of the block, for messages.

    Raises
    ------
        DataError: when there are not as many conditions as unknowns.
        ExactnessError: when the interval test does not succeed, or the digits are others.
    """
    published = system.published(digits)
    result = krawczyk(conditions, published, RADIUS)
    if result.outcome is not Outcome.UNIQUE:
        raise ExactnessError(
            f"`{key}`: the interval test gives {result.outcome!s} near the digits "
            f"({result.witness})"
        )
    for x, y in zip(published, result.box, strict=True):
        if not is_rounding(x, y, digits):
            raise ExactnessError(f"`{key}`: the exact method lies outside the digits")
    return result
