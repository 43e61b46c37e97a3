"""A true solution near the digits of a file, proved, and everything that follows from it.

:func:`prove` applies the interval test (:mod:`glmref.prove.krawczyk`) to a method file in the sweep
form, of one component or two (the classes ``sweep``, ``pair-sweep`` and ``splitting``), and says
what follows:

1. *The solution.* The system of the file has exactly one root within ``radius`` of its digits, and
   the root lies within one unit of their last place.
2. *G-symplectic*: holds for every value of the unknowns (theorem in :mod:`glmref.method.sweep`);
   V^T G V = G is exact arithmetic.
3. *Symmetric*: holds for every value of the unknowns, since D and X are palindromic as affine
   expressions (same module); the sign pattern, G and V are exact arithmetic.
4. *Order*: the equations of the file vanish at the root, and with 2 and 3 the theorems of
   :mod:`glmref.prove.equations` carry a few trees of odd order to all trees. Whether the
   equations are enough is decided by :mod:`glmref.prove.order_conditions`. A splitting method that
   is not symmetric needs trees of every order (theorem 1; its starting series is zero).
5. *Parasitism-free*: the growth parameter of every eigenvalue of V but 1 is an equation of the
   file, for each component.
6. *Explicit stages*: their diagonal entry is an equation of the file. Pairs are explicit.
7. *Start and finish*: :mod:`glmref.prove.starting`.

Redundant to all this, and evaluated on request, every one of the residuals up to the
order is a ball around zero, of width below :data:`WIDTH`, over the enclosure of the root.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, cached_property
from typing import Any, Protocol

from ..catalogue.strict_json import shown
from ..errors import DataError, ExactnessError
from ..exact import Ball, Exact, ball, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from ..method.sweep import SweepForm
from ..theory.error_constants import commutator_row
from ..theory.trees import Tree, trees
from .classes import representatives
from .equations import Series
from .krawczyk import Krawczyk, Outcome, is_rounding, krawczyk
from .order_conditions import covered
from .starting import Blocks, Target, prove_blocks
from .system import SweepSystem

#: Redundant identities are enclosed in balls around zero no wider than this.
WIDTH = 1e-50
_RADIUS = re.compile(r"\d{1,99}(\.\d{1,99})?(e-\d{1,3})?")


@dataclass(frozen=True)
class Enclosure:
    """A proof record: what was proved about the method of a file, and by what.

    Attributes
    ----------
    values : Mapping[str, Ball]
        Enclosing ball of every unknown, by name; every identity is evaluated with them.
    radius : Fraction
        Half-width of the box in which the root is unique.
    root : Krawczyk
        The interval test of the equations.
    order : int
        The order proved (a lower bound; see ``next_order`` for the upper one).
    nystrom_order : int
        The same on second-order systems; ``order`` for one component.
    blocks : Blocks
        What was proved about the start and the finish.
    signs : tuple[tuple[int, ...], ...] or None
        Diagonal of E = V L, the symmetry of the values, by component; ``None`` for a product of
        flows that is not symmetric.
    system : SweepSystem
        The equations.
    form : SweepForm
        The numbers of the sweep form.
    principal : Mapping[Tree, Any]
        The principal parts that are unknowns.
    """

    values: Mapping[str, Ball]
    radius: Fraction
    root: Krawczyk
    order: int
    nystrom_order: int
    signs: tuple[tuple[int, ...], ...] | None
    system: SweepSystem = field(repr=False)
    form: SweepForm = field(repr=False)
    principal: Mapping[Tree, Any] = field(repr=False)
    blocks: Blocks = field(default_factory=Blocks)

    @cached_property
    def series(self) -> tuple[Series, ...]:
        """For each order claimed, in the order of :attr:`~.system.SweepSystem.families`."""
        return tuple(
            self.system.series(self.form, self.principal, order, family=family, starts=True)
            for order, family in self.system.families
        )

    @cached_property
    def identity(self) -> bool:
        """Whether the first values are the solution itself, to the orders claimed."""
        return all(
            x[0].is_zero() is True
            for order, family in self.system.families
            for t, x in self.system.series(
                self.form, self.principal, order, family=family, wanted=()
            ).zeta.items()
            if t.order < order
        )  # fmt: skip

    @cached_property
    def width(self) -> float:
        """Largest magnitude over all residuals up to the order, growth parameters included.

        Raises
        ------
        ExactnessError
            Where one of them does not vanish.
        """
        return _checked_width(self.system, self.form, self.series)

    @property
    def contraction(self) -> float:
        """Largest row sum of the interval test, see :class:`.krawczyk.Krawczyk`."""
        return self.root.contraction

    @property
    def started(self) -> Mapping[str, int]:
        """The claims about the start and the finish that were proved."""
        return self.blocks.orders

    @cached_property
    def next_order(self) -> float:
        """Lower bound of what no starting method can remove one order higher (one component).

        Positive, it proves that the order is not higher: see :func:`obstruction`.
        """
        _, principal = self.system.read(self.values)
        further = self.system.series(self.form, principal, self.order + 1)
        return obstruction(further, self.order)


def prove(document: Mapping[str, Any]) -> Enclosure:
    """Prove what a file with an ``"enclosure"`` claims, from the file alone.

    Parameters
    ----------
    document : Mapping[str, Any]
        The parsed JSON object, of a class that :mod:`glmref.prove.system` reads.

    Raises
    ------
    DataError
        When the file asks for more than its equations give.
    ExactnessError
        When the interval test does not find exactly one root near the digits.
    """
    system = SweepSystem(document)
    if not system.families:
        raise DataError("a file with an `enclosure` must claim an order of at least 1")
    signs = _checked_signs(system)
    root = root_of(document, system)
    form, principal = system.read(dict(zip(system.unknowns, root.box, strict=True)))
    form = replace(form, explicit=system.explicit)
    for name, weights in zip(system.names, form.D.values(), strict=True):
        for i, x in enumerate(weights):
            if ball(x).is_zero() is not False:
                raise ExactnessError(f"`{name}[{i + 1}]` may be zero: {x!r}")
    record = Enclosure(
        values=dict(zip(system.unknowns, root.box, strict=True)),
        radius=radius_of(document),
        root=root,
        order=system.claimed,
        nystrom_order=max(system.claimed, system.claimed_second_order),
        signs=signs,
        system=system,
        form=form,
        principal=principal,
    )
    if "starting" in document:  # not by `replace`, which would drop the series
        blocks = prove_blocks(document, Target.of(document, system, record.series))
        object.__setattr__(record, "blocks", blocks)
    return record


def _checked_width(system: SweepSystem, form: SweepForm, series: Sequence[Series]) -> float:
    """Return the largest magnitude of what the theorems say vanishes.

    Raises
    ------
    ExactnessError
        When it does not.
    """
    small: list[Any] = [
        x
        for (order, _), found in zip(system.families, series, strict=True)
        for t, x in found.residual.items()
        if t.order <= order
    ]
    small += [system.growth(e, form) for e in system.equations if e.kind == "growth"]
    small += [row[0] - 1 for c in form.blocks for row in c.U]  # U u = 1
    width = max(ball(x).magnitude() for x in small)
    # one by one: the largest of numbers that are no numbers may be any of the others
    if not all(ball(x).contains_zero() and ball(x).magnitude() < WIDTH for x in small):
        raise ExactnessError(
            f"a redundant condition is not enclosed: the largest residual is {width:.3g}, "
            f"and it must be a ball around zero below {WIDTH}"
        )
    return width


def _checked_signs(system: SweepSystem) -> tuple[tuple[int, ...], ...] | None:
    """Return diagonals of E = V L of a system whose equations give all conditions up to its orders.

    Raises
    ------
    DataError
        Where it is not symmetric and no product of flows, or equations are missing.
    """
    signs = system.signs()
    if signs is not None and any(x[0] != 1 for x in signs):
        signs = None
    if signs is None and system.kind_of_flow() is None:
        names = "`b`, `c`, `w`, `v` and `stages`" if system.is_partitioned else "`D` and `X`"
        raise DataError(
            f"{names} must be palindromic up to a sign for each row of X, with V and G to match: "
            f"only then do the even orders follow"
        )
    for order, family in system.families:
        for n in range(1, order + 1, 1 if signs is None else 2):
            if not covered(system, n, family):
                trees_of = representatives(n, system.stage_order, family)
                raise DataError(
                    f"the equations of the file do not give the conditions of order {n}; those of "
                    f"{', '.join(map(str, trees_of))} would (at stage order {system.stage_order})"
                )
    return signs


def radius_of(document: Mapping[str, Any]) -> Fraction:
    """Return the radius of the box of the interval test of a file.

    Raises
    ------
    DataError
        For anything but a decimal from 1e-999 to 1e-60.
    """
    text = document.get("enclosure", {}).get("radius", "1e-60")
    if not isinstance(text, str) or not _RADIUS.fullmatch(text):
        raise DataError(f"`enclosure.radius` must be a number such as '1e-60', got {shown(text)}")
    radius = Fraction(text)
    if not 0 < radius <= Fraction(1, 10**60):
        raise DataError(f"`enclosure.radius` must be positive and at most 1e-60, got {shown(text)}")
    return radius


class Square(Protocol):
    """A system of as many equations as unknowns, over any scalar."""

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Their names."""
        ...

    @property
    def equations(self) -> Sequence[Any]:
        """Each with its ``text``."""
        ...

    def residuals(self, values: Sequence[Any]) -> list[Any]:
        """Return left minus right side of every equation."""
        ...


def root_of(document: Mapping[str, Any], system: Square) -> Krawczyk:
    """Run the interval test around the digits of the file.

    Raises
    ------
    DataError
        Where the equations are not as many as the unknowns.
    ExactnessError
        Where the test does not find exactly one root within the digits.
    """
    radius, digits = radius_of(document), document.get("digits", 75)
    if len(system.equations) != len(system.unknowns):
        raise DataError(
            f"`enclosure.equations` must be as many as the unknowns ({len(system.unknowns)}), "
            f"got {len(system.equations)}"
        )
    texts = [document["unknowns"][name] for name in system.unknowns]
    published = [ball(parse(x, digits=digits)) for x in texts]
    result = krawczyk(system.residuals, published, radius)
    if result.outcome is not Outcome.UNIQUE:
        _check_satisfied(document, system, published)
        raise ExactnessError(
            f"{document.get('name', 'the file')}: the interval test gives {result.outcome!s} "
            f"within {document['enclosure'].get('radius')} of the digits ({result.witness})"
        )
    for name, x, y in zip(system.unknowns, published, result.box, strict=True):
        if not is_rounding(x, y, digits):
            _check_satisfied(document, system, published)
            raise ExactnessError(
                f"the root lies further than half a unit of the last digit from `unknowns.{name}`"
            )
    return result


def _check_satisfied(
    document: Mapping[str, Any], system: Square, published: Sequence[Ball]
) -> None:
    """Name the equation that has no solution within the digits, where there is one."""
    for e, x in zip(system.equations, system.residuals(published), strict=True):
        if ball(x).is_zero() is False:
            raise ExactnessError(
                f"{document.get('name', 'the file')}: the equation {e.text!r} is not satisfied "
                f"within the published digits"
            )


def shift_matrix(order: int) -> Matrix:
    """Return how residuals of ``order + 1`` change with zeta_1 of ``order``: (trees, trees).

    A change delta of zeta_1 at the trees of one order adds ``delta(t)`` to R([t]) and takes
    ``ways * delta(kept)`` from R(t') for each way to cut one leaf off t'.
    """
    place = {t: j for j, t in enumerate(trees(order))}
    rows = (commutator_row(t, place) for t in trees(order + 1))
    return tuple(tuple(Exact(row.get(j, 0)) for j in range(len(place))) for row in rows)


def obstruction(series: Series, order: int) -> float:
    """Return a lower bound of what no starting method can remove at ``order + 1``.

    Let S' be any starting method with which the method has order ``order + 1``. It gives order
    ``order`` too, and composing it with the flow over a multiple of h makes its principal part
    agree with ours at the single node. The matrices of :func:`shift_matrix` for the orders 2 to
    ``order - 1`` have full column rank, so it agrees there as well, order by order. At ``order``
    they may differ, by delta; then R + (shift matrix) delta = 0. So n R = 0 for every row n with
    n (shift matrix) = 0, and a ball n R that excludes zero refutes it.

    Returns
    -------
    float
        The largest lower bound of ``|n R|`` over a rational basis of such rows n, each scaled to
        largest entry 1; 0.0 when nothing was refuted.
    """
    best = 0.0
    residuals = [ball(series.residual[t]) for t in trees(order + 1)]
    for row, size in _annihilators(order):
        best = max(best, ball(linalg.dot(row, residuals)).lower_magnitude() / size)
    return best


@cache
def _annihilators(order: int) -> list[tuple[linalg.Vector, float]]:
    """Return a rational basis of the n with n (shift matrix) = 0, each with its largest entry.

    It is the same for every method of the order.

    Raises
    ------
    ExactnessError
        When a shift matrix below the order has not full column rank.
    """
    for n in range(2, order):
        if linalg.rank(shift_matrix(n)) < len(trees(n)):  # pragma: no cover - a theorem
            raise ExactnessError(f"the starting series is not unique at order {n}")
    basis = linalg.nullspace(linalg.transpose(shift_matrix(order)))
    return [(row, max(x.magnitude() for x in row)) for row in basis]
