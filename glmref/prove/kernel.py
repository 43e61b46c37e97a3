"""The kernel: it finds what is true of a method, and the witnesses that the judge decides by.

It gives no verdict: a claim holds or fails where the judge (:mod:`glmref.judge`) accepts the
certificate written of what was found here (:mod:`.verdicts`).

Claims that are true or false and lists of numbers are decided by the judge alone, who is asked for
both answers (:mod:`.facts`). Of an order a rule here finds a *range*, a lower and an upper bound,
over exact numbers or balls: a residual whose ball overlaps zero is not known to vanish, one whose
ball excludes zero does not, for every method in the balls. :meth:`Kernel.find` compares the range
with what is declared.

For a file with an enclosure the lower bounds of the one true method within its digits
come from :mod:`glmref.prove.implications`, whose hypotheses are checked there each time.

What the kernel trusts: the arithmetic of :mod:`glmref.exact`, elimination in
:mod:`glmref.exact.linalg`, trees, and the series of the judge.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

from ..catalogue.claims import (
    CLAIMS,
    EFFECTIVE_ORDER,
    FINISHING_ORDER,
    NYSTROM_ORDER,
    NYSTROM_STARTING_ORDER,
    ORDER,
    ORDER_IDENTITY,
    STARTING_ORDER,
)
from ..errors import ExactnessError
from ..exact import Exact, Scalar, ball, linalg
from ..exact.judging import as_scalar, fast_judge
from ..exact.linalg import Matrix, Vector
from ..findings import Proof
from ..judge.refusals import Refused
from ..method import Method
from ..method.preconsistency import (
    output,
    outputs,
)
from ..theory.coefficients import (
    difference,
    first_nonzero,
    is_zero,
)
from ..theory.order import MANY_STARTS, highest_order
from ..theory.starting_series import (
    Judged,
    NotPreconsistent,
    Prepared,
    StartingSeries,
    component,
    tableau,
)
from ..theory.trees import Tree, counted, is_nystrom, paths, single, tree
from .digits import DigitRules, Sized
from .find_modified import ModifiedRules
from .find_rows import RowRules
from .implications import Implied
from .ranges import MAX_ORDER, Range

_ZERO = Exact(0)
#: Claims of orders: whether principal parts are free, and whether on second-order systems.
KINDS = {
    ORDER_IDENTITY.key: (False, False),
    EFFECTIVE_ORDER.key: (True, False),
    NYSTROM_ORDER.key: (False, True),
}
#: Largest order to which trees of one method that carries one value are compared.
HIGHEST = 14
#: Largest order where the trees without branches decide.
LONGEST_PATH = 20
#: A residual above this is no rounding; nor is one above that where digits were meant to count.
SMALL, ROUNDING = 1e-3, 1e-9


@dataclass(frozen=True)
class Found:
    """What the kernel found about a claim: a proposal, which the judge accepts or not.

    Attributes
    ----------
    truth : bool or None
        Whether the claim is true; ``None`` where no rule decides it.
    proof : Proof
        Which arithmetic decides, or would decide, it.
    value : object
        The value that was found, or as much as is known of it.
    residual : float
        Size of the identity that decides, 0.0 when it holds exactly.
    reason : str
        One sentence.
    """

    truth: bool | None
    proof: Proof
    value: object
    residual: float
    reason: str


class Kernel(RowRules, DigitRules, ModifiedRules):
    """The rules, for one method.

    Parameters
    ----------
    method : Method
        A method or a pair.
    implied : Implied or None
        What its enclosure proves, or ``None``.
    judged : callable or None
        Returns the series that the judge has of the method, where it has one, see
        :meth:`.certificate.Shared.judged`.
    """

    def __init__(
        self,
        method: Method,
        implied: Implied | None = None,
        judged: Callable[[bool, bool, bool | str], Judged | None] | None = None,
    ) -> None:
        self.method: Any = method
        self.implied = implied
        self.is_pair = len(method.components) > 1
        #: (A, U, B, V) by colour
        self.blocks: dict[str, tuple[Matrix, Matrix, Matrix, Matrix]] = {
            c.colour: c.matrices for c in method.components
        }
        #: output functionals by colour, where the method declares them
        self.outputs: dict[str, Vector | None] = {
            c.colour: None if c.output is None else output(c)  # refuses one that reads another
            for c in method.components
        }
        self.palette = method.palette
        self.shared = method.shared
        self.one_step = all(len(b[3]) == 1 for b in self.blocks.values())
        self.exact = all(linalg.is_exact(*b) for b in self.blocks.values())
        timed = method.in_time
        #: the kernel that knows the order: another one where time is a component of its own
        self.timed = self if timed is method else Kernel(timed, judged=judged)
        self.judged = judged
        #: what is known of orders to digits, which the finder and the writer ask for
        self.sized: dict[tuple[Any, ...], dict[str, Sized]] = {}
        #: the searches made, their series, and beside these those of start and finish, by
        #: whether principal parts are free and whether on second-order systems
        self._ranges: dict[tuple[bool, bool], Range] = {}
        self.series: dict[tuple[bool, bool], StartingSeries] = {}
        self._starts: dict[tuple[bool, bool], tuple[StartingSeries, Any]] = {}

    # -- claims ----------------------------------------------------------------------------------

    def find(self, claim: str, declared: object) -> Found:
        """Find whether an order, or the orders of rows, are those declared."""
        try:
            if CLAIMS[claim].type is dict:
                return self._rule(claim)(declared)
            return self._find_range(claim, declared)
        except ExactnessError as error:
            return self._made(None, exact=self.exact, value=None, residual=0.0, reason=str(error))

    @staticmethod
    def _made(
        truth: bool | None, *, exact: bool, value: object, residual: float, reason: str
    ) -> Found:
        if truth is None and not reason:
            reason = "no rule decides it" if exact else "the published digits do not decide it"
        proof = Proof.EXACT if exact else Proof.ENCLOSED
        return Found(truth, proof, value, residual, reason)

    def _rule(self, claim: str) -> Any:
        """Return the rule of a claim by its key; of an order it is a property, a :class:`Range`."""
        return getattr(self, "_" + claim.replace("-", "_"))

    def _find_range(self, claim: str, declared: object) -> Found:
        found = self.range(claim)
        wanted = int(declared)  # type: ignore[call-overload]
        truth = None
        if found.lower > wanted or (found.upper is not None and found.upper < wanted):
            truth = False
        elif found.lower == found.upper == wanted:
            truth = True
        residual = found.residual
        if truth is True:
            residual = max(found.sizes[:wanted], default=0.0)
        reason = found.sentence
        if truth is None and found.lower < wanted:
            reason = "; ".join(
                x for x in (f"order {wanted} is not proved: {found.lower} is", reason) if x
            )
        return self._made(
            truth,
            exact=found.exact,
            value=found.value,
            residual=residual,
            reason=reason,
        )

    # -- orders ----------------------------------------------------------------------------------

    @cached_property
    def _components(self) -> dict[str, Prepared]:
        return {c: component(*b, self.outputs[c]) for c, b in self.blocks.items()}

    def range(self, claim: str) -> Range:
        """Return proved bounds of an order; the theorem: :mod:`glmref.theory.starting_series`."""
        try:
            if claim in KINDS:
                free, nystrom = KINDS[claim]
                return self._with_implied(claim, self.order_range(free=free, nystrom=nystrom))
            return self._with_implied(claim, self._rule(claim))
        except Refused as error:
            raise ExactnessError(str(error)) from error

    def _with_implied(self, claim: str, found: Range) -> Range:
        implied = self.implied.at_least.get(claim) if self.implied else None
        if implied is not None and implied > found.lower:
            if found.upper is not None and found.upper < implied:
                raise ExactnessError(
                    f"the enclosure gives {claim} {implied} and the digits at most {found.upper}"
                )
            found = replace(found, lower=implied, exact=False)
        return found

    @property
    def _order(self) -> Range:
        """One value carried: it is the solution. Several: some starting method must exist.

        The identity as principal part is a start, so its order is a lower bound; where it equals
        the upper bound with a free one, its residuals are shown: they are the local error.
        """
        identity = self.order_range(free=False)
        if self.one_step:
            return identity
        free = self.order_range(free=True)
        return identity if identity.value == free.value else free

    def order_range(self, *, free: bool, nystrom: bool = False) -> Range:
        """Return bounds by the trees: residuals exactly 0 below, one that excludes 0 above."""
        if self.timed is not self:
            return self.timed.order_range(free=free, nystrom=nystrom)
        if free and self.method.system:  # principal parts are determined by trees that do not count
            raise ExactnessError("effective orders are judged where all trees count, c = A 1")
        key = (free, nystrom)
        if key not in self._ranges:
            self._ranges[key] = self._search(free=free, nystrom=nystrom)
        return self._ranges[key]

    def _counts(self, *, nystrom: bool) -> Callable[[Tree], bool]:
        """Return which trees count: of second-order systems, or of the systems of the method."""
        return counted("nystrom" if nystrom else self.method.system)

    def _search(self, *, free: bool, nystrom: bool) -> Range:
        try:
            components = self._components
        except NotPreconsistent as reason:
            return Range(0, 0, exact=self.exact, reason=f"not preconsistent: {reason}")
        except ExactnessError as reason:
            return Range(0, None, exact=self.exact, reason=str(reason))
        if not self.shared or (
            set(components) == set("fk") and not (nystrom or self.method.system)
        ):
            found = self._along_paths(components, free=free, nystrom=nystrom)
            if found is not None:
                return found
        counts = self._counts(nystrom=nystrom)
        judged = self._judges(components, nystrom, free, nystrom)
        series = StartingSeries(components, self.palette, free=free, counts=counts, judged=judged)
        self.series[free, nystrom] = series
        found = None if free else self._above_implied(series, nystrom)
        if found is not None:
            return found
        most = self._most(nystrom=nystrom)
        lower, sizes = 0, []
        proved = all(c.certain for c in components.values())
        for n in range(1, most + 1):
            if n > (6 if self.is_pair else MAX_ORDER[0] - 2):  # the first of many may fail already
                beyond = self._beyond(series, lower, n, sizes, nystrom)
                if beyond is not None:
                    return beyond
            level: dict[Tree, Scalar] = {}
            answers: dict[Tree, bool | None] = {}
            failing = None
            for t in series.advance():
                level[t] = first_nonzero(series.residual(t))
                answers[t] = level[t].is_zero()
                if answers[t] is False:  # one tree decides: the others of its order are left
                    failing = t
                    break
            if failing is not None:
                upper, more = (n - 1, "") if series.complete else (None, MANY_STARTS)
                return Range(
                    lower, upper, str(failing), level[failing].magnitude(), tuple(sizes),
                    self.exact, more, n - 1,
                )  # fmt: skip
            series.settle()
            proved = proved and all(x is True for x in answers.values())
            lower = n if proved else lower
            open_ = [level[t].magnitude() for t, x in answers.items() if x is None]
            sizes.append(max([sizes[-1] if sizes else 0.0, *open_]))
        for n in (most + 1, most + 2):
            beyond = self._beyond(series, lower, n, sizes, nystrom)
            if beyond is not None:
                return beyond
        return Range(lower, None, sizes=tuple(sizes), exact=self.exact, value=most)

    def _judges(
        self, components: Mapping[str, Prepared], nystrom: bool, free: bool, trees: bool | str
    ) -> Judged | None:
        """Return the series of the judge, where it is that which is looked for."""
        simple = self.exact and all(len(c.N) == 1 and c.certain for c in components.values())
        return self.judged(nystrom, free, trees) if simple and self.judged else None

    def residuals(self, *, free: bool) -> dict[Tree, Scalar]:
        """Return the residuals of all trees one order beyond that of :meth:`order_range`.

        There are none of an order beyond :func:`~glmref.theory.order.highest_order`, or of a
        method without a starting series.
        """
        if self.timed is not self:
            return self.timed.residuals(free=free)
        order = self.order_range(free=free).value + 1
        if order > highest_order(self.palette):
            return {}
        series = self.series.get((free, False))
        try:
            if series is None or series.along_paths or series.order > order:
                counts = self._counts(nystrom=False)
                series = StartingSeries(self._components, self.palette, free=free, counts=counts)
        except (NotPreconsistent, ExactnessError):
            return {}
        while series.order < order:
            series.advance()
        return {t: first_nonzero(series.residual(t)) for t in series.level(order)}

    def _along_paths(
        self, components: dict[str, Prepared], *, free: bool, nystrom: bool
    ) -> Range | None:
        """Return the order of a pair whose stages are the solution, by trees without branches.

        Otherwise the result is ``None``.

        The theorem is that of `paths` and `nystrom-paths` in ``docs/certificates.md``, section 4:
        where the stages are right along these trees, every other tree has a multiple of the
        residual of the one of its order and colour, since numbers ``|t|! / gamma(t) N_|t|`` are the
        series of ``sum N_n h^n y^(n)`` along the solution, so that E acts on them as it does on the
        N_n. Multistep formulas are of this kind: they ask for quadrature alone.

        With a free principal part no start reaches order n where the residuals r_f and r_k of the
        two trees of order n have a sum that is not zero. For on q' = p, p' = q, where no other
        trees count, the step takes principal values to theirs by exp(h J) + h^n E + O(h^(n+1)), J =
        [[0, 1], [1, 0]], with E = diag(r_f, r_k) for even n and [[0, r_f], [r_k, 0]] for odd n:
        the eigenvalue at exp(h) is wrong by (r_f + r_k) h^n / 2, and the change from one start to
        another is a similarity, which keeps eigenvalues. Below order 9 all trees are compared in
        that case, where only these two orders and no series are kept.
        """
        which = "nystrom-paths" if nystrom else "paths"
        series = StartingSeries(
            components, self.palette, free=False, along_paths=True,
            judged=self._judges(components, nystrom, False, which),
        )  # fmt: skip
        proved = all(c.certain for c in components.values())
        if not (proved and series.simple):
            return None
        on_solution = True
        for n in range(1, LONGEST_PATH + 1):
            level = {t: first_nonzero(series.residual(t)) for t in series.advance()}
            failing = next((t for t, x in level.items() if x.is_zero() is False), None)
            if failing is not None:
                if not nystrom and n <= (6 if self.shared else MAX_ORDER[1]):
                    return None
                residual = level[failing]
                if free:
                    residual = sum(level.values(), _ZERO)
                    if residual.is_zero() is not False:
                        return None
                else:
                    self.series[free, nystrom] = series
                size = residual.magnitude()
                return Range(n - 1, n - 1, str(failing), size, exact=self.exact, value=n - 1)
            series.settle()
            zero = all(x.is_zero() is True for x in level.values())
            if not (zero and on_solution) or (n == 1 and not self._at_one_time(series)):
                return None
            # of the next order a tree may still fail: that needs no other trees
            on_solution = self._right_along_paths(series, "f" if nystrom else "fk")
        return None

    @staticmethod
    def _right_along_paths(series: StartingSeries, colours: str) -> bool:
        """Tell whether stages of these colours are the solution on paths through the last order."""
        solved, n, reached = series.solved, series.order, fast_judge().series.path_orders
        try:
            return all(min(reached(solved.method, solved, c, n)) >= n for c in colours)
        except Refused:
            return False

    def _at_one_time(self, series: StartingSeries) -> bool:
        """Return whether shared stages have the same abscissae for Q and P."""
        if not self.shared:
            return True
        return is_zero(difference(*map(series.abscissae, "fk"))) is True

    def nearly(self) -> list[float]:
        """Return the largest residual through each order, zero or not: measured, never a verdict.

        The numbers are taken as balls, and u with V u = u although U u = 1 may fail by a rounding.
        The list ends with the first order whose residual is large, in the thousands of trees
        beyond order 10 with the first whose residual is no rounding to 9 digits.
        """
        if self.timed is not self:
            A, c = self.blocks["o"][0], self.method.abscissae_given
            rows = [sum(row, _ZERO) - x for row, x in zip(A, c, strict=True)]
            gap = max(x.magnitude() for x in rows)
            if gap > ROUNDING:
                return self.timed.nearly()
            plain = Kernel(replace(self.method, abscissae_given=None))  # c is A 1, but for digits
            return [max(x, gap) for x in plain.nearly()]
        found = self.order_range(free=not self.one_step)
        if found.value > MAX_ORDER[0] - 2:  # what was computed once is not computed again
            return [*found.sizes, found.residual]
        most = self._most_measured
        try:
            components = {
                c: component(
                    _as_balls(A), _as_balls(U), _as_balls(B), V, self.outputs[c], measured=True
                )
                for c, (A, U, B, V) in self.blocks.items()
            }
            counts = self._counts(nystrom=False)
            series = StartingSeries(components, self.palette, free=not self.one_step, counts=counts)
            sizes = [
                max(
                    (linalg.dot(row, c.u) - 1).magnitude()
                    for c in components.values()
                    for row in c.U
                )
            ]
            for n in range(most):
                bush = self._bush(series, n + 1) if n + 1 > MAX_ORDER[0] - 2 else None
                if bush is not None and bush.magnitude() > ROUNDING:
                    return [*sizes, bush.magnitude()]
                level = series.advance()
                largest = max(first_nonzero(series.residual(t)).magnitude() for t in level)
                sizes.append(max(largest, sizes[-1]))
                if n == 0:
                    sizes.pop(0)
                if largest > (SMALL if n + 1 <= MAX_ORDER[0] - 2 else ROUNDING):
                    return sizes
        except (NotPreconsistent, ExactnessError):
            return []
        beyond = self._bush(series, most + 1)
        return sizes if beyond is None else [*sizes, beyond.magnitude()]

    def _most(self, *, nystrom: bool = False) -> int:
        """Return the largest order to which trees are compared.

        One value carried needs no cuts of trees.
        """
        if not self.is_pair:
            return HIGHEST if self.one_step else MAX_ORDER[0]
        if self.shared:
            return MAX_ORDER[min(len(self.blocks), 4)]
        # of the trees of second-order systems there are few
        return HIGHEST - 1 if nystrom and self.one_step else MAX_ORDER[1]

    @property
    def _most_measured(self) -> int:
        """The same where nothing is to be proved: two orders fewer where trees have cuts."""
        most = self._most()
        if self.is_pair:
            return min(most, MAX_ORDER[2]) - 2
        return most if self.one_step else most - 2

    def _beyond(
        self,
        series: StartingSeries,
        lower: int,
        n: int,
        sizes: Sequence[float],
        nystrom: bool = False,
    ) -> Range | None:
        """Return the range where a tree of order n with n - 1 leaves refutes that order."""
        for bush, residual in self._bushes(series, n, nystrom).items():
            if residual.is_zero() is False:
                size = residual.magnitude()
                return Range(lower, n - 1, str(bush), size, tuple(sizes), self.exact, value=n - 1)
        return None

    def _above_implied(self, series: StartingSeries, nystrom: bool) -> Range | None:
        """Return the range of one value each where a bush refutes more than is implied.

        Of one method where the trees of what is implied are thousands: it stands without them.
        """
        key = NYSTROM_ORDER.key if nystrom else ORDER.key
        p = self.implied.at_least.get(key, 0) if self.implied else 0
        wanted = p > MAX_ORDER[0] - 2 if not self.is_pair else p and not self.shared
        return self._beyond(series, 0, p + 1, (), nystrom) if wanted else None

    def _bushes(self, series: StartingSeries, n: int, nystrom: bool = False) -> dict[Tree, Scalar]:
        """Return conditions of order n of a method that carries one value, by trees with leaves.

        Of a separable pair there is one for each colour of the root. A free principal part changes
        them, but not the residual of the tree without branches, the term of degree n in R(z) less
        that of exp(z): on y' = z y it is a number, which commutes with R(z). A pair in that case
        has none here.
        """
        if (self.shared and self.is_pair) or not self.one_step or (series.free and self.is_pair):
            return {}
        level = paths(n, tuple(self.palette.items()))
        if not series.free:
            leaves = {root: single(below[0]) for root, below in self.palette.items()}
            level = [tree([leaf] * (n - 1), root) for root, leaf in leaves.items()]
        stages = tableau({c: (A, B) for c, (A, _, B, _) in self.blocks.items()})
        found = {}
        for t in level:
            if not nystrom or is_nystrom(t):
                values = tuple(map(as_scalar, stages.value(t.judged)))
                seen = linalg.matvec(series.components[t.colour].W, values)
                found[t] = seen[0] - Fraction(1, t.density)
        return found

    def _bush(self, series: StartingSeries, n: int) -> Scalar | None:
        """Return the condition of order n of one method that carries one value."""
        return None if self.is_pair else next(iter(self._bushes(series, n).values()), None)

    @cached_property
    def _stage_order(self) -> Range:
        """Stages that are the solution at their abscissae: xi(t) = c^|t| / gamma(t).

        With the series of the order, which is unique up to a shift (that moves c and xi alike) and
        to the principal parts N beta of the last order: these add U N beta to the stages at a tree,
        which is beta for all stages alike where 1 is a simple eigenvalue.

        Where trees of order p were the last to be compared, the principal parts of order p stay 0.
        If the stages are the solution then, they are so with those that order p + 1 asks for: xi,
        eta and W R are multiples |t|! / gamma(t) of numbers that depend on |t| and the colour, and
        so is beta, which L determines from trees with several branches, ``beta = W R``. Trees with
        one branch ask for ``K beta = 0``, and K = 1 where 1 is a simple eigenvalue.
        """
        free = not self.one_step
        order = self.order_range(free=free)
        top, exact = order.value, order.exact
        if not top:
            return Range(0, order.upper, exact=exact, reason="found 0")
        if (free, False) not in self.timed.series:  # a start with free principal parts, by paths
            reason = "trees with branches, which stage order asks for, were not compared"
            return Range(1, None, exact=exact, value=1, reason=reason)
        # of one value carried each order stands by itself, and the first that fails is the last
        series = self.timed.series[free, False].through(1 if self.one_step else top)
        if order.upper is None and not series.simple:  # others may have a higher order
            return Range(1 if order.lower else 0, None, exact=exact, value=1, reason=order.reason)
        c = [series.abscissae(colour) for colour in series.palette]
        # of an additive method the abscissa of a stage is that of every part; c apart is A 1
        alone = not self.method.additive and self.timed is self
        one = alone or all(is_zero(difference(*x)) for x in pairwise(c))
        if not one and any(x.is_zero() is False for y in pairwise(c) for x in difference(*y)):
            leaf = str(series.level(1)[0])
            return Range(0, 0, exact=exact, reason="a stage has two abscissae", failing=leaf)
        defect, solved = fast_judge().rules_orders.stage_defect, series.solved
        found = self._compared(
            series, order, top, lambda t, last: defect(solved, t, last),
            lambda t, gap: f"found {t.order - 1}", f"found {top}",
            proved=bool(order.lower) and one, exact=exact, first=2,
        )  # fmt: skip
        return found if found.failing else replace(found, lower=min(found.lower, order.lower))

    def _compared(
        self,
        series: StartingSeries,
        known: Range,
        top: int,
        gap: Callable[[Any, bool], list],
        fails: Callable[[Tree, Vector], str],
        agrees: str,
        *,
        proved: bool,
        exact: bool,
        first: int = 1,
    ) -> Range:
        """Return bounds of the order through which stages, a start or a finish are right.

        Parameters
        ----------
        series : StartingSeries
            Of the method, whose order has the bounds `known`.
        top : int
            The last order to look at.
        gap : callable
            What must vanish at a tree of the judge; if told so, less what the principal parts N
            beta of the order change, which are free only where the order is known to end there.
        fails, agrees : callable, str
            Say what fails at a tree, and what holds where nothing does.
        proved : bool
            Whether what is asked below the order `first` is known to hold.
        exact : bool
            Whether all numbers are exact.
        """
        lower = first - 1 if proved else 0
        for q in range(first, top + 1):
            for t in series.through(q).level(q):
                strict = loose = series.scalars(gap(t.judged, False))
                if series.free and q >= known.lower:
                    loose = series.scalars(gap(t.judged, True))
                if is_zero(loose) is False:
                    return Range(lower, q - 1, exact=exact, value=q - 1,
                                 reason=fails(t, loose), failing=str(t))  # fmt: skip
                proved = proved and bool(is_zero(loose if q == known.upper else strict))
            lower = q if proved else lower
        return Range(lower, known.upper, exact=exact, value=top, reason=agrees)

    # -- starts and finishes -----------------------------------------------------------------------

    @property
    def _starting_order(self) -> Range:
        return self._start_range(nystrom=False)

    @property
    def _nystrom_starting_order(self) -> Range:
        return self._start_range(nystrom=True)

    def _start_range(self, *, nystrom: bool) -> Range:
        """Return where the start of the file agrees with the starting series.

        That is unique up to a shift along the flow, which is fixed at a single vertex, and up to
        the principal parts of the last order.
        """
        start = self.method.starting
        free = not self.is_pair
        if start is None and not self.is_pair:
            return Range(0, 0, exact=True, reason="the file gives no starting method")
        if self.timed is not self:
            raise ExactnessError("the order of a start is judged where c = A 1")
        known = self.order_range(free=free, nystrom=nystrom)
        base = NYSTROM_ORDER if nystrom else ORDER_IDENTITY if self.is_pair else ORDER
        known = self._with_implied(base.key, known)
        p = known.value
        if not p:
            return Range(0, known.upper, exact=self.exact,
                         reason="the method has no starting series to agree with")  # fmt: skip
        claim = NYSTROM_STARTING_ORDER if nystrom else STARTING_ORDER
        compared = "all trees of second-order systems" if nystrom else "all trees"
        if start is not None and self._is_implied(claim.key, known):
            return Range(0, p, exact=False, value=p,
                         reason=f"agrees on {compared} of order {p} or less")  # fmt: skip
        series, beside = self._beside(free=free, nystrom=nystrom)
        given, rules, solved = beside.start, fast_judge().rules_starts, series.through(p).solved
        # where 1 is a multiple eigenvalue another series may have a higher order
        proved = series.simple or known.upper is not None
        if series.along_paths and start is not None:
            which = "nystrom-paths" if nystrom else "paths"
            proved = proved and rules.uses_right_stages(given, solved.method, which, p)
        multiples = {c: (1, *[0] * (len(x.u) - 1)) for c, x in series.components.items()}
        if start is not None:
            multiples = {x.colour: tuple(u for (u,) in x.V) for x in start.components}
        for c, x in series.components.items():
            gap = difference(multiples[c], x.u)
            bad = next((i for i, y in enumerate(gap) if y.is_zero() is False), None)
            if bad is not None:
                reason = (
                    f"the multiple of y differs by {gap[bad].magnitude():.6g} in value {bad + 1}"
                )
                return Range(0, 0, exact=self.exact, reason=reason, failing="")
            proved = proved and all(y.is_zero() is True for y in gap)
        # so that the output is that of the start at one vertex
        sigma = rules.ahead(given, solved) if free else 0

        def fails(t: Tree, gap: Vector) -> str:
            if start is None:
                return f"a carried value starts with a term of {t}"
            at, size = next((i, y) for i, y in enumerate(gap, 1) if y.is_zero() is False)
            return f"tree {t} differs by {size.magnitude():.6g} in value {at}"

        found = self._compared(
            series, known, p, lambda t, last: rules.start_gap(given, solved, t, sigma, last), fails,
            f"agrees on {compared} of order {p} or less" if start is not None else
            "every carried value starts with zero",
            proved=proved, exact=self.exact and self._exact_start(),
        )  # fmt: skip
        # order p + 1, which was not asked for, may determine the principal parts
        lower = min(found.lower, known.lower, p - (free and known.upper is None))
        others = found.failing and not series.complete  # which may agree with it
        return replace(found, lower=lower, upper=None if others else found.upper)

    def _is_implied(self, claim: str, known: Range) -> bool:
        """Return whether the enclosure gives a start or finish the highest order there is."""
        implied = self.implied.at_least.get(claim) if self.implied else None
        return implied == known.value == known.upper

    def _exact_start(self) -> bool:
        start: Any = self.method.starting
        if start is None:
            return True
        return start.is_exact

    def _beside(self, *, free: bool, nystrom: bool) -> tuple[StartingSeries, Any]:
        """Return the series of an order, and those of start and finish as the judge has them."""
        if (free, nystrom) not in self._starts:
            series, start, finish = self.series[free, nystrom], self.method.starting, None
            given = [x for x in (start, self.method.finishing) if x is not None]
            if (judged := series.judged) is not None and all(x.is_exact for x in given):
                proof = SimpleNamespace(method=judged.series.method, of_method=judged.kept)
                found = fast_judge().rules_starts.FinishCase(proof, None)
            else:
                series, zero = self._own(series), ((_ZERO,),)
                table = {c: (zero, zero * len(x.u)) for c, x in series.components.items()}
                if start is not None:
                    table = {c.colour: (c.A, c.B) for c in start.components}
                if self.method.finishing is not None:
                    finish = tableau({"o": (self.method.finishing.A, (self.method.finishing.b,))})
                found = SimpleNamespace(start=tableau(table), finish=finish)
            self._starts[free, nystrom] = series, found
        return self._starts[free, nystrom]

    def _own(self, series: StartingSeries) -> StartingSeries:
        """Return a series over the numbers of the package, before the first order."""
        return StartingSeries(
            series.components, self.palette, free=series.free, counts=series.counts,
            along_paths=series.along_paths,
        )  # fmt: skip

    @cached_property
    def _finishing_order(self) -> Range:
        """Trees on which the finish, after the output of the start, gives y back.

        ``(a b)(t) = a(t) + sum over cuts of b(kept) * product of a(branches)``, a the series of the
        output of the start and b that of the finish.
        """
        finish, start = self.method.finishing, self.method.starting
        if finish is None:
            return Range(0, 0, reason="the file gives no finishing method")
        if start is None:
            raise ExactnessError("a finish is compared with the start of its file, which has none")
        if self.timed is not self:
            raise ExactnessError("the order of a finish is judged where c = A 1")
        known = self.order_range(free=True)
        p = known.value
        reason = f"agrees on all trees of order {p} or less"
        if p and self._is_implied(FINISHING_ORDER.key, known):
            return Range(0, p, exact=False, value=p, reason=reason)
        (w,) = outputs(self.method.components)
        exact = self.exact and self._exact_start() and linalg.is_exact(finish.A, (finish.b,))
        if (linalg.dot(w, start.u) - 1).is_zero() is not True:
            raise ExactnessError("a finishing method needs an output that starts from y itself")
        if not p:
            return Range(0, known.upper, exact=exact, reason=reason)
        series, beside = self._beside(free=True, nystrom=False)
        undone, read = fast_judge().rules_starts.finished, series.solved.w["o"]

        def fails(t: Tree, gap: Vector) -> str:
            return f"tree {t} differs by {gap[0].magnitude():.6g} in value 1"

        found = self._compared(
            series, known, p, lambda t, last: [undone(beside.start, beside.finish, read, t)],
            fails, reason, proved=True, exact=exact,
        )  # fmt: skip
        return replace(found, lower=min(found.lower, known.lower))


def _as_balls(matrix: Matrix) -> Matrix:
    """Return the matrix with every entry but exact zeros as a ball."""
    return tuple(tuple(x if x.vanishes() else ball(x) for x in row) for row in matrix)
