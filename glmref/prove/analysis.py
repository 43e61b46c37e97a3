"""Say what a method is when nothing is claimed: the ``glmref-analysis-1`` record."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..catalogue.claims import (
    A_STABLE,
    CONSISTENT,
    DENSE_ORDER,
    EXPLICIT,
    G_SYMPLECTIC,
    L_STABLE,
    NYSTROM_ORDER,
    ORDER,
    ORDER_IDENTITY,
    PARASITISM_FREE,
    PRECONSISTENT,
    SOLUTION,
    STAGE_ORDER,
    SYMMETRIC,
    SYMMETRIC_REDUCED,
    W_ORDER,
    ZERO_STABLE,
)
from ..catalogue.lookup import load, method_of, path_of, unread
from ..errors import BudgetError, ExactnessError
from ..exact import Scalar, linalg
from ..exact.expression import shown_number
from ..exact.linalg import Matrix, Vector
from ..findings import Proof
from ..method import Method
from ..system.arguments import number
from ..system.budget import READING, left, limited, spend
from ..system.shown import Shown
from ..theory.order import error_norm, order_of
from ..theory.periodicity import periodicity
from ..theory.reduction import without_idle_stages
from ..theory.residues import rates_on_one_sign, residues
from ..theory.stability_interval import imaginary_interval, real_interval
from ..theory.symmetry import Symmetry
from .digits import rounded_up, staircase_of
from .facts import Facts, facts_of
from .kernel import SMALL, Kernel
from .ranges import Range
from .verifier import budget_of, facts_for, ignored
from .wrong_entry import suspected

if TYPE_CHECKING:
    from ..system.process import Say

FORMAT = "glmref-analysis-1"


@dataclass(frozen=True, repr=False)
class Analysis(Shown):
    """Facts of one method, JSON-ready. ``None`` stands for what could not be decided.

    Attributes
    ----------
    method : str
        Its name.
    stages, values : int or list[int]
        s and r (pairs: of both halves).
    implicit_stages : list[int] or None
        Numbers from 1 of those that need an equation solved. Of a pair those of its halves count
        one after another, or, where both right-hand sides are evaluated at the same, once.
    order : int
        The order; with ``principal`` = ``"identity"`` the first value is the solution, with
        ``"free"`` a start and a finish belong to the method.
    order_proved : list[int or None]
        A proved lower and a proved upper bound of it.
    order_to_digits : str or None
        Of rounded decimals the largest residual through ``order``, such as ``"2.0e-16"``. All
        orders, and the residuals beyond, are then those of the numbers within their digits.
    order_identity : int
        Order of the first value taken as the solution.
    order_witness : str
        The tree that decides.
    order_nystrom : int or None
        Of a pair, the order on q' = M^-1 p, p' = k(q).
    consistency_witness : str
        Which row of V u = u, U u = 1 or B 1 + V v = u + v is off.
    error_constants : dict[str, float]
        Residuals at order p + 1 by tree, as floats: what the method gives less the elementary
        weight of the solution.
    error_norm : float
        Euclidean norm of residual / symmetry over these trees (Hairer, Norsett, Wanner 1993,
        section II.1).
    order_parts : list[int] or None
        Of an additive method, the order of each part for y' = f_c(t, y) alone.
    order_embedded : dict[str, int] or None
        Orders of the embedded rows by name.
    order_dense : int or None
        Order of the dense output.
    order_w : int or None
        Of a Rosenbrock method, the order with any matrix in the place of the Jacobian.
    wrong_entry : str or None
        The row whose sum is not c, and the entry of A or b that is wrong with what it should be, as
        far as the c and the order of the file tell.
    quadrature_constant : float or None
        C in the local error C h^(p+1) y^(p+1) when y' = g(t) is integrated.
    stability : dict[str, Any]
        ``A``, ``L``: whether A- and L-stable. ``real``, ``imaginary``: length of the interval [-x,
        0] and of [0, iy] on which no eigenvalue of M(z) leaves the closed unit disc.
        ``periodicity``: largest y below which all are simple and of modulus one; of a pair on the
        oscillator. ``math.inf`` for a whole half-axis.
    stability_parts : dict[str, dict] or None
        Of an additive method the same of each implicit part for y' = f_c(t, y) alone, by its
        number.
    g_symplectic : dict[str, Any] or None
        ``{"holds", "G", "D"}``; ``None`` for an additive method, of which no form is defined.
    symmetric : dict[str, Any] or None
        ``{"holds", "L", "P"}``, and where it does not hold ``"reduced"``: whether it does without
        values that are not needed or follow from others, and ``"why"``. ``None`` for an additive
        method.
    growth : list[dict[str, Any]]
        ``[{"eigenvalue", "mu"}, ...]``; of a pair ``"mu_q"`` and ``"mu_p"`` at an eigenvalue that V
        and V^ share, ``"mu_qq"`` or ``"mu_pp"`` at one of V or V^ only.
    growth_rates : dict[str, float] or None
        Of a pair whose V and V^ share only the eigenvalue 1 and whose stages are shared: to first
        order in h, the parasitic part grows at this rate times the mean of ``|H_pq|`` on a
        Hamiltonian of one degree of freedom whose H_pq has one sign, by that sign. ``None`` for
        others.
    proof : Proof
        The kind of proof all of this has.
    undecided : dict[str, str] or None
        What was not decided, and why: a budget was spent, or a zero of a number was not decided.
    """

    method: str
    stages: int | list[int]
    values: int | list[int]
    explicit: bool | None
    implicit_stages: list[int] | None
    preconsistent: bool | None
    consistent: bool | None
    zero_stable: bool | None
    order: int
    order_proved: list[int | None]
    principal: str
    order_identity: int
    stage_order: int
    order_witness: str
    error_constants: dict[str, float]
    g_symplectic: dict[str, Any] | None
    symmetric: dict[str, Any] | None
    growth: list[dict[str, Any]]
    parasitism_free: bool | None
    abscissae: list[str] | None
    proof: Proof
    stability: dict[str, Any]
    order_nystrom: int | None
    consistency_witness: str
    error_norm: float
    quadrature_constant: float | None
    order_parts: list[int] | None = None
    order_embedded: dict[str, int] | None = None
    order_dense: int | None = None
    growth_rates: dict[str, float] | None = None
    order_w: int | None = None
    order_to_digits: str | None = None
    wrong_entry: str | None = None
    stability_parts: dict[str, dict[str, Any]] | None = None
    undecided: dict[str, str] | None = None

    def __repr__(self) -> str:
        to = f" to {self.order_to_digits}" if self.order_to_digits else ""
        return f"<Analysis {self.method or '(unnamed)'}: order {self.order}{to}, {self.proof}>"

    def as_json(self) -> dict[str, Any]:
        """Return the record, with its format, as JSON-ready values."""
        found = {"format": FORMAT, **asdict(self), "proof": str(self.proof)}
        found["stability"] = plain_ends(self.stability)
        if self.stability_parts is not None:
            found["stability_parts"] = {k: plain_ends(x) for k, x in self.stability_parts.items()}
        additive = ("parasitism_free", "growth") if self.g_symplectic is None else ()
        for key in (*_OF_SOME, *additive):
            if key in additive or found[key] is None:
                del found[key]
        return found


#: What only methods have that it applies to.
_OF_SOME = (
    *("order_parts", "order_embedded", "order_dense", "order_w", "order_to_digits", "growth_rates"),
    *("wrong_entry", "g_symplectic", "symmetric", "stability_parts", "undecided"),
)


def plain_ends(stability: Mapping[str, Any]) -> dict[str, Any]:
    """Return ends of stability intervals as JSON has them: a whole half-axis is ``"infinity"``."""
    return {key: "infinity" if x == math.inf else x for key, x in stability.items()}


def analyze(method: Method | str | Path, *, budget: float | None = None) -> Analysis:
    """Compute everything there is to know of a method; claims play no part.

    Parameters
    ----------
    method : Method or str or Path
        A GLM or a pair, from a file or made by hand; its name or its file.
    budget : float or None
        Seconds of processor time; by default 60 for a file of the user, no limit else.

    Raises
    ------
    BudgetError
        When they are spent before anything can be said.
    UsageError, DataError
        For a name or a file that cannot be read.
    """
    if budget is not None:
        budget = number("budget", budget)
    if isinstance(method, str | Path):
        budget = budget_of(path_of(method), budget)
    method = method_of(method)
    with limited(budget):
        return _analyzed(_Questions(facts_for(method), budget))


def record_of(name: str | Path, further: Callable[[Method, Any], Any]) -> tuple[Any, Any]:
    """Return the record of a method.

    Questions about a user's file are answered in processes of their own.

    One that does not return from an operation within its budget is ended. The next takes over the
    answers that were found, and leaves out the question.

    Parameters
    ----------
    name : str or Path
        The method.
    further : callable
        What is looked at besides, given the method and its record; its result is a JSON value.

    Returns
    -------
    tuple
        The record, and that result, ``None`` where it was not found in time.

    Raises
    ------
    BudgetError, UsageError, DataError
        As :func:`analyze`.
    """
    # processes are for the command line; `analyze` is for Python, and starts faster without
    from ..system.process import apart

    path = path_of(name)
    budget = budget_of(path)
    if budget is None:
        method = load(path)
        record = analyze(method).as_json()
        return record, further(method, record)
    answers: list[Any] = []
    used = 0.0

    def program(say: Say) -> None:
        method = load(path)
        say(None, budget - used)
        with limited(budget, used):
            found = _analyzed(_Questions(facts_for(method), budget, answers, say)).as_json()
        say({"found": (found, None)}, 0.0)
        say({"found": (found, further(method, found))}, None)

    while True:
        said = apart(program, READING)
        if not said.messages:
            raise unread(path, said)
        *_, last = said.messages
        if not isinstance(last, dict):  # it was ended in no question
            raise said.error(budget)
        if "found" in last:
            record, more = last["found"]
            return record, more
        answers += [x for x in said.messages if isinstance(x, list)]
        answers.append([last["nothing"], str(said.error(last["allowed"]))])
        used += said.seconds


class _Questions:
    """Questions about a method, each with a share of the budget, and why one has no answer.

    Parameters
    ----------
    facts : Facts
        Of the method.
    budget : float or None
        Seconds of processor time for all questions.
    answered : sequence
        Answers to the first questions, each with the reason why there is none or ``""``.
    say : Say
        Is given what stands for an answer before it is looked for, and the answer, as JSON values.
    """

    def __init__(
        self,
        facts: Facts,
        budget: float | None,
        answered: Sequence[tuple[Any, str]] = (),
        say: Say = ignored,
    ) -> None:
        self.facts = facts
        self.share = None if budget is None else budget / SHARES
        self.undecided: dict[str, str] = {}
        self._answered, self._say = iter(answered), say

    def ask(
        self,
        name: str,
        what: Callable[[Facts], Any],
        nothing: Any = None,
        seconds: float | None = None,
    ) -> Any:
        """Return the answer; where there is none, note that and return ``nothing``."""
        answer, why = next(self._answered, (None, None))
        if why is None:
            answer, why = self._found(what, nothing, seconds or self.share)
            self._say([answer, why], 0.0)
        if why:
            self.undecided[name] = why
        return answer

    def _found(
        self, what: Callable[[Facts], Any], nothing: Any, seconds: float | None
    ) -> tuple[Any, str]:
        try:
            with limited(seconds):
                spend()  # what is left to be asked when all is spent takes no time
                seconds, allowed = left()
                self._say({"nothing": nothing, "allowed": allowed}, seconds)
                return what(self.facts), ""
        except (BudgetError, ExactnessError) as error:
            # a search that was left half-way is not to be gone on with
            self.facts = facts_of(self.facts.method, implied=self.facts.implied)
            return nothing, str(error)

    def truth(
        self,
        claim: str,
        seconds: float | None = None,
        of: Callable[[Facts], Facts] = lambda f: f,
        where: str = "",
    ) -> bool | None:
        """Return whether a claim of truth is true, of the method or of a part of it."""

        def known(facts: Facts) -> tuple[bool | None, str]:
            facts = of(facts)
            found = facts.known(claim)
            return found.truth, found.reason or "the digits do not decide it"

        answer = self.ask(where + claim, known, None, seconds)
        if answer is None:
            return None
        truth, reason = answer
        if truth is None:
            self.undecided[where + claim] = reason
        return truth

    def range(self, claim: str) -> Range:
        """Return proved bounds of an order, or the reason why no upper bound was found."""
        found = self.ask(claim, lambda f: asdict(f.nominal.kernel.range(claim)))
        if found is None:
            return Range(0, None, reason=self.undecided[claim])
        return Range(**found)


def _shared(q: _Questions) -> dict[str, Any]:
    order, identity = q.range(ORDER.key), q.range(ORDER_IDENTITY.key)
    stages = q.range(STAGE_ORDER.key)
    same = order.value == identity.value or q.facts.is_one_step
    constants, norm = q.ask("error-constants", _constants, ({}, 0.0))
    settled = order.lower == order.upper
    misses = q.ask(
        "consistency", lambda f: [x.witness for x in f.nominal.consistencies if x.witness], []
    )
    why = q.ask("staircase", staircase, "")
    return {
        "method": q.facts.method.name,
        "explicit": q.truth(EXPLICIT.key),
        "preconsistent": q.truth(PRECONSISTENT.key),
        "consistent": q.truth(CONSISTENT.key, of=_consistent_as),
        "zero_stable": q.truth(ZERO_STABLE.key),
        "order": order.value,
        "order_proved": [order.lower, order.upper],
        "principal": "identity" if same else "free",
        "order_identity": identity.value,
        "stage_order": stages.value,
        "order_witness": "; ".join(
            x for x in (why, "" if settled else _open(order), order.sentence) if x
        ),
        "error_constants": constants,
        "parasitism_free": None if q.facts.method.additive else q.truth(PARASITISM_FREE.key),
        "proof": Proof(q.ask("proof", lambda f: str(f.nominal.proof), str(q.facts.proof))),
        "consistency_witness": "; ".join(dict.fromkeys(misses)),
        "error_norm": norm,
        "order_embedded": q.ask("order-embedded", lambda f: _row_orders(f.nominal.kernel)),
        "wrong_entry": q.ask("wrong entry", lambda f: suspected(f.method, order.value), "", SEARCH)
        or None,
        "order_to_digits": q.ask("order-to-digits", lambda f: _size_to(f, order.value)),
    }


def _consistent_as(facts: Facts) -> Facts:
    """Return the method itself where it is consistent as rounded, else what its digits allow."""
    itself = facts.nominal is facts or facts.truth(CONSISTENT.key)
    return facts if itself else facts.nominal


def _size_to(facts: Facts, order: int) -> str | None:
    """Return the largest residual through an order of rounded decimals, rounded up."""
    if facts.nominal is facts:
        return None
    sizes = _proved_sizes(facts).get(SOLUTION, ())[1:] or _measured_sizes(facts)
    return rounded_up(max(sizes[:order], default=Fraction(0))) if sizes else None


def _proved_sizes(facts: Facts) -> Mapping[str, Sequence[Fraction]]:
    """Return bounds of the residuals through each order by rows of weights, from order 0."""
    try:
        return facts.kernel.sizes_to_digits if facts.kernel.exact else {}
    except ExactnessError:
        return {}


def _measured_sizes(facts: Facts) -> list[Fraction]:
    """Return the same from order 1 as measured.

    What is beyond the range of doubles is as large as any.
    """
    return [Fraction(repr(min(x, sys.float_info.max))) for x in facts.kernel.nearly()]


def _constants(facts: Facts) -> tuple[dict[str, float], float]:
    found = facts.nominal.local_error
    return {str(t): _real(x) for t, x in found.items()}, error_norm(found)


def _row_orders(kernel: Kernel) -> dict[str, int] | None:
    """Return orders of the embedded rows by name.

    ``None`` without rows, or without the u they need.
    """
    try:
        return {name: x.range(kernel.row_claim).value for name, x in kernel.row_kernels} or None
    except ExactnessError:
        return None


def _stability(q: _Questions, part: int = 0) -> dict[str, Any]:
    """Find A- and L-stability and the intervals of a method that is one method on linear systems.

    That is one method, a Rosenbrock method, or one part of an additive method.
    """
    where = f"part {part}: " if part else ""

    def linear(f: Facts) -> Facts:
        return facts_of(f.method.part(part)) if part else f

    def interval(name: str, of: Callable[[Any], Any]) -> Any:
        return q.ask(f"{where}{name} interval", lambda f: of(linear(f).linear).end, None, STABILITY)

    return {
        "A": q.truth(A_STABLE.key, STABILITY, linear, where),
        "L": q.truth(L_STABLE.key, STABILITY, linear, where),
        "real": interval("real", real_interval),
        "imaginary": interval("imaginary", imaginary_interval),
    }


def _stability_of_parts(q: _Questions) -> dict[str, dict[str, Any]] | None:
    """Return the same of each implicit part of an additive method, by its number."""
    m = q.facts.method
    implicit = [n for n in range(1, m.k + 1) if m.part(n).implicit_stages]
    return {str(n): _stability(q, n) for n in implicit} or None


def _open(order: Range) -> str:
    return f"order {order.lower} is proved"


#: The share of the budget that one question may take is one in so many.
SHARES = 4
#: Seconds of processor time for the entry that is wrong.
SEARCH = 5.0
#: Seconds of processor time for each question of stability.
STABILITY = 2.0


def staircase(facts: Facts) -> str:
    """Return how well a rounded tableau satisfies the conditions beyond its proved order.

    Rational numbers of methods that carry one value are evaluated with a bound of all roundings,
    each row of weights for itself and Nystrom methods on second-order systems; the sizes, rounded
    up, are those that a claim ``order-to-digits`` states. Others are measured.

    Returns
    -------
    str
        Such as "order 5 to 2.1e-12, order 3 to 3.2e-17, order 0 exactly"; ``""`` where no order
        beyond the proved one is nearly reached.
    """
    kernel = facts.kernel
    known = kernel.range(kernel.row_claim)
    proved = known.lower
    alone = kernel.one_step and not kernel.is_pair and not facts.method.embedded
    if alone and proved == known.upper and known.residual >= SMALL:
        return ""  # the largest residual through any higher order is not below this one
    sizes = _proved_sizes(facts)
    if not sizes:
        return _steps([Fraction(0), *_measured_sizes(facts)], proved)
    lower = {name: x.range(kernel.row_claim).lower for name, x in kernel.row_kernels}
    said = {name: _steps(x, lower.get(name, proved)) for name, x in sizes.items()}
    named = [f"row {name}: {x}" if len(said) > 1 else x for name, x in said.items() if x]
    where = "on second-order systems " if kernel.row_claim == NYSTROM_ORDER.key and named else ""
    return where + "; ".join(named)


def _steps(sizes: Sequence[Fraction], proved: int) -> str:
    """Return orders beyond the proved one, with the largest residual through each, rounded up."""
    steps = staircase_of(sizes, proved)
    return ", ".join([*steps, f"order {proved} exactly"]) if steps else ""


def _analyzed_sum(q: _Questions) -> Analysis:
    """Analyze an additive method: the whole by trees in the colours of its parts, and each part."""
    m = q.facts.method
    return Analysis(
        **_shared(q),
        stages=len(m.b) if m.rosenbrock else m.s,
        values=m.r,
        implicit_stages=[i for i, row in enumerate(m.gamma, 1) if row[i - 1].is_zero() is not True]
        if m.rosenbrock
        else list(m.implicit_stages),
        g_symplectic=None,
        symmetric=None,
        growth=[],
        abscissae=None,
        stability=_stability(q) if m.rosenbrock else {},
        stability_parts=None if m.rosenbrock else _stability_of_parts(q),
        order_nystrom=None,
        quadrature_constant=None,
        order_w=q.range(W_ORDER.key).value if m.rosenbrock else None,
        order_parts=None
        if m.rosenbrock
        else q.ask(
            "order-parts",
            lambda f: [order_of(m.part(n), principal="identity").order for n in range(1, m.k + 1)],
        ),
        undecided=q.undecided or None,
    )


def _analyzed(q: _Questions) -> Analysis:
    m = q.facts.method
    if m.additive:
        return _analyzed_sum(q)
    single = q.facts.is_single
    stages, values = [len(c.A) for c in m.components], [len(c.V) for c in m.components]
    shared = _shared(q)

    def form(name: str, write: Callable[[Any], Any]) -> Any:
        return q.ask(G_SYMPLECTIC.key, lambda f: write(getattr(f.g_symplecticity, name)))

    reversal = q.ask(
        SYMMETRIC.key, lambda f: _reversal(f.symmetry, single), _reversal(None, single)
    )
    nystrom = not single and (not m.shared or (m.document or {}).get("class") == "nystrom")
    quadrature = q.ask("quadrature-constant", _quadrature) if single else None
    stability = _stability(q) if single else {}
    stability["periodicity"] = q.ask("periodicity interval", _periodicity, None, STABILITY)
    return Analysis(
        **shared,
        stages=stages[0] if single else stages,
        values=values[0] if single else values,
        implicit_stages=q.ask("implicit stages", lambda f: list(f.method.implicit_stages)),
        g_symplectic={
            "holds": q.truth(G_SYMPLECTIC.key),
            "G": form("G", _matrix),
            "D": form("D", _vector) if single else {x: form(x, _vector) for x in ("D_P", "D_Q")},
        },
        symmetric={"holds": (holds := q.truth(SYMMETRIC.key))}
        | reversal
        | (_reduced(q) if holds is False and (not single or values != [1]) else {}),
        growth=q.ask("growth", _growth, []),
        growth_rates=None if single else q.ask("growth rates", _growth_rates),
        abscissae=q.ask("abscissae", lambda f: _vector(f.abscissae)),
        stability=stability,
        order_nystrom=q.range(NYSTROM_ORDER.key).value if nystrom else None,
        quadrature_constant=quadrature,
        order_dense=q.range(DENSE_ORDER.key).value if single and m.dense is not None else None,
        undecided=q.undecided or None,
    )


def _reversal(found: Symmetry | None, single: bool) -> dict[str, Any]:
    """Return the involutions of the values, and the exchanges of stages, those of P first."""
    names = ("L",) if single else ("L", "L_hat")
    none: list[Any] = [None] * len(names)
    Ls = list(found.involutions.values()) if found else []
    exchanges = [_stages(x) for x in found.exchanges.values()] if found else []
    given = zip(names, map(_matrix, Ls or none), strict=True)
    stages = (exchanges or none)[::-1]
    return {**dict(given), "P": stages[0] if single else stages}


def _reduced(q: _Questions) -> dict[str, Any]:
    """Return whether a method that is not symmetric is so without values it can do without.

    A multistep method is symmetric where alpha_m = -alpha_(k-m) and beta_m = beta_(k-m), which as
    a tableau carries h f of values that it carries, too (Hairer, Lubich, Wanner 2006, XV.1).
    A splitting is often written with strokes of length 0, which make stages that are not used.
    """

    def known(f: Facts) -> tuple[bool | None, str]:
        if not f.is_single:
            smaller = without_idle_stages(f.method)
            if smaller is None:
                return None, ""
            less = Facts(smaller)
            truth = less.truth(SYMMETRIC.key)
            return truth, "without the stages whose slopes are not used" if truth else ""
        if f.method.multistep is not None:
            alpha, beta = f.method.multistep
            gaps = [x + y for x, y in zip(alpha, reversed(alpha), strict=True)]
            gaps += [x - y for x, y in zip(beta, reversed(beta), strict=True)]
            truths = [x.is_zero() for x in gaps]
            truth = None if None in truths and False not in truths else all(truths)
            why = "alpha_m = -alpha_(k-m), beta_m = beta_(k-m)"
            return truth, f"{why}: the values h f follow from the values y" if truth else ""
        truth = f.truth(SYMMETRIC_REDUCED.key)
        return truth, f.reduction.witness if truth else ""

    truth, why = q.ask("symmetric in reduced form", known, None, STABILITY) or (None, "")
    if truth is None and not q.facts.is_single:  # no stage is idle
        return {}
    return {"reduced": truth, "why": why}


def _growth(facts: Facts) -> list[dict[str, Any]]:
    found = []
    for g in facts.parasitism.growths:
        number = g.mu is not None and "mu_q" not in g.listed
        shown = {x: shown_number(m[0][0]) if number else _matrix(m) for x, m in g.listed.items()}
        found.append({"eigenvalue": shown_number(g.eigenvalue), **shown})
    return found


def _growth_rates(facts: Facts) -> dict[str, float] | None:
    found = residues(facts.method)
    if found is None:
        return None
    rates = rates_on_one_sign(found)
    return {f"H_pq {'>' if sign > 0 else '<'} 0": x for sign, x in rates.items()}


def _periodicity(facts: Facts) -> float | None:
    """Return the periodicity interval.

    Over published digits, that a form is conserved is proved apart.
    """
    method = facts.method
    conserving = False
    if not method.is_exact and facts.truth(G_SYMPLECTIC.key) and method.G is not None:
        try:
            linalg.inverse(method.G)
            conserving = True
        except ExactnessError:
            pass
    return periodicity(method, conserving=conserving).value


def _quadrature(facts: Facts) -> float | None:
    found = facts.nominal.quadrature_error
    return None if found is None else _real(found[0])


def _real(x: Scalar) -> float:
    return complex(x).real


def _vector(values: Vector | None) -> list[str] | None:
    return None if values is None else [shown_number(x) for x in values]


def _matrix(rows: Matrix | None) -> list[list[str]] | None:
    return None if rows is None else [[shown_number(x) for x in row] for row in rows]


def _stages(order: Sequence[int] | None) -> list[int] | None:
    return None if order is None else [i + 1 for i in order]
