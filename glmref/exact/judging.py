"""The judge with FLINT's numbers: the modules of :mod:`glmref.judge` over another arithmetic.

:func:`fast_judge` loads them a second time with this module in the place of
:mod:`glmref.judge.arithmetic`: rationals are ``fmpq``, intervals are ``arb`` of 512 bits. The rules
are the very same files. Where a ball is wider or narrower than the interval of the other
arithmetic, something may be undecided in one of them only; neither accepts what is false.
"""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, lru_cache
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

import flint

from .. import judge
from ..errors import BudgetError, ExactnessError
from ..judge import arithmetic
from ..judge.arithmetic import Number, Ring
from ..judge.refusals import Refused, Undecided
from ..system.budget import spend
from .number import Ball, Exact
from .products import sum_of_products

PRECISION = 512  # bits of a ball

Fraction = flint.fmpq
tick = spend
#: The types of rational numbers.
RATIONAL = (flint.fmpq, int, flint.fmpz)


def rational_of(text: str) -> flint.fmpq:
    """Return the rational of a decimal such as -1.25e-3."""
    number, _, exponent = text.partition("e")
    whole, _, places = number.partition(".")
    n, power = int(whole + places), int(exponent or 0) - len(places)
    return flint.fmpq(n * 10**power) if power >= 0 else flint.fmpq(n, 10**-power)


def _upper(x: flint.arb) -> flint.fmpq:
    """Return a rational above |x| for all x of a ball."""
    return x.abs_upper().fmpq()


class Interval(Ring):
    """A ball of real numbers; its truth value says that it excludes 0, or is a refusal."""

    __slots__ = ("ball",)

    def __init__(self, ball: flint.arb) -> None:
        self.ball = ball

    @classmethod
    def ends(cls, low: flint.fmpq, high: flint.fmpq) -> Interval:
        """Return an interval that holds all numbers between two rationals."""
        return cls(flint.arb(low).union(flint.arb(high)))

    def as_ball(self) -> Ball:
        """Return the ball as a number of the package."""
        return Ball.of_real(self.ball)

    def middle(self) -> Interval:
        """Return the midpoint, an interval without width."""
        return Interval(self.ball.mid())

    def inside(self, other: Interval) -> bool:
        """Tell whether the interval lies in the interior of another."""
        return other.ball.contains_interior(self.ball)

    def meet(self, other: Interval) -> Interval:
        """Return an interval that holds the intersection."""
        return Interval(self.ball.intersection(other.ball))

    def positive(self) -> bool:
        """Tell whether all numbers of the interval are positive."""
        return bool(self.ball > 0)

    def is_zero(self) -> bool:
        """Tell whether the interval holds 0 only."""
        return self.ball.is_zero()

    def least(self) -> flint.arb:
        """Return a measure of the least |x|, to be compared with those of other intervals."""
        return self.ball.abs_lower()

    def __float__(self) -> float:
        """Return a number near the midpoint."""
        return float(self.ball.mid())

    def holds_zero(self) -> bool:
        """Tell whether 0 lies in the interval."""
        return self.ball.contains(0)

    def inverse(self) -> Interval:
        """Return 1 / x of an interval that excludes 0."""
        return Interval(1 / self.ball)

    def __bool__(self) -> bool:
        if self.ball.contains(0):
            raise Undecided("an interval holds 0: nothing is decided")
        return True

    def __add__(self, other: Interval | flint.fmpq) -> Interval:
        if isinstance(other, Interval):
            return Interval(self.ball + other.ball)
        if type(other) in RATIONAL:
            return Interval(self.ball + other)
        return NotImplemented

    __radd__ = __add__

    def __neg__(self):
        return Interval(-self.ball)

    def __mul__(self, other: Interval | flint.fmpq) -> Interval:
        if isinstance(other, Interval):
            return Interval(self.ball * other.ball)
        if type(other) in RATIONAL:
            return Interval(self.ball * other)
        return NotImplemented

    __rmul__ = __mul__

    def __eq__(self, other):
        raise Refused("intervals are not compared")

    __hash__ = None  # type: ignore[assignment]


def rounded(x) -> Interval:
    """Return an interval around a rational; it is made sooner than found by the hash of one."""
    return Interval(flint.arb(x))


class Gradient(arithmetic.Gradient):
    """An interval with its derivatives by the unknowns, exact zeros left out."""

    __slots__ = ()
    value: Interval
    by: dict[int, Interval]

    def __init__(self, value: Interval, by: dict[int, Interval]) -> None:
        self.value, self.by = value, by

    @staticmethod
    def dot(pairs: Iterable[tuple]) -> Gradient:
        """Return sum x_i y_i."""
        return dot_of_gradients(pairs)


def dot_of_rationals(x: Sequence[flint.fmpq], y: Sequence[flint.fmpq]) -> flint.fmpq:
    """Return sum x_i y_i."""
    spend()
    found = flint.fmpq(0)
    for a, b in zip(x, y, strict=True):
        if a and b:
            found += a * b
    return found


def product_of_rationals(M: list, N: list) -> list:
    """Return the product of two matrices."""
    spend()
    return (flint.fmpq_mat(M) * flint.fmpq_mat(N)).tolist()


class Applied:
    """A matrix of rationals and intervals, made ready for many vectors."""

    def __init__(self, rows: list) -> None:
        self.rows, self.rational, self.balls = rows, None, []

    def to_rationals(self, x: list) -> list:
        """Return M x, M and x rational."""
        spend()
        if self.rational is None:
            entries = [y for row in self.rows for y in row]
            self.rational = flint.fmpq_mat(len(self.rows), len(x), entries)
        return (self.rational * flint.fmpq_mat(len(x), 1, x)).entries()

    def to_intervals(self, x: list) -> list:
        """Return M x of a vector of intervals; where a row is 0, the exact zero.

        The terms are added one by one: a product of matrices would round wide balls to fewer bits.
        """
        spend()
        if not self.balls:
            self.balls = [[(j, _split(y)[0]) for j, y in enumerate(row) if type(y) is Interval or y]
                          for row in self.rows]  # fmt: skip
        points, found = [y.ball for y in x], []
        for row in self.balls:
            total = None
            for j, y in row:
                total = y * points[j] if total is None else total + y * points[j]
            found.append(flint.fmpq(0) if total is None else Interval(total))
        return found


def spread(nums: Sequence[int], codes: Sequence[int]) -> flint.fmpz_poly:
    """Return a polynomial in generators, one in a single variable with the codes as powers."""
    found = [0] * (codes[len(nums) - 1] + 1)
    for code, n in zip(codes, nums, strict=False):
        found[code] = n
    return flint.fmpz_poly(found)


def sum_of_spread(
    terms: Iterable[tuple[int, flint.fmpz_poly, flint.fmpz_poly]],
) -> tuple[list[int], int]:
    """Return the integers at codes, and the denominator, of a sum of p q / den."""
    spend()
    sums: dict[int, flint.fmpz_poly] = {}
    for den, first, second in terms:
        den = int(den)
        sums[den] = sums[den] + first * second if den in sums else first * second
    common = math.lcm(*sums)
    whole = flint.fmpz_poly()
    for den, found in sums.items():
        whole += found if den == common else found * (common // den)
    return [int(x) for x in whole.coeffs()], common


def products_of_whole(
    vectors: list[list[flint.fmpz]], A: list[list[flint.fmpz]]
) -> list[list[flint.fmpz]]:
    """Return A x for every vector x, all of integers."""
    spend()
    return (flint.fmpz_mat(vectors) * flint.fmpz_mat(A).transpose()).tolist() if vectors else []


def dot_of_intervals(x: Sequence, y: Sequence) -> Interval | flint.fmpq:
    """Return sum x_i y_i of intervals and rationals; an exact zero stays one."""
    spend()
    exact, found = flint.fmpq(0), None
    for a, b in zip(x, y, strict=True):
        if type(a) is Interval:
            if type(b) is Interval:
                term = a.ball * b.ball
            elif b:
                term = a.ball * b
            else:
                continue
        elif type(b) is Interval:
            if not a:
                continue
            term = b.ball * a
        else:
            exact += a * b
            continue
        found = term if found is None else found + term
    if found is None:
        return exact
    return Interval(found + exact if exact else found)


def dot_of_gradients(pairs: Iterable[tuple]) -> Gradient:
    """Return sum x_i y_i of intervals, rationals and gradients."""
    spend()
    value, by = flint.arb(0), {}
    for a, b in pairs:
        u, du = _split(a)
        v, dv = _split(b)
        value += u * v
        for other, more in ((v, du), (u, dv)):
            for k, g in more.items():
                term = g.ball * other
                by[k] = by[k] + term if k in by else term
    return Gradient(Interval(value), {k: Interval(x) for k, x in by.items()})


_NONE: dict[int, Interval] = {}


def _split(x: Number) -> tuple[flint.arb, dict[int, Interval]]:
    """Return the ball of a number and its derivatives."""
    if type(x) is Gradient:
        return x.value.ball, x.by
    return (x.ball if type(x) is Interval else rounded(x).ball), _NONE


def newton_sums(
    Y: list[list[int]], values: list[Interval], gradients: list[dict[int, Interval]]
) -> tuple[list[flint.fmpq], list[flint.fmpq]]:
    """Return rationals above |Y f| and above the row sums of |1 - Y G|, row by row.

    See :func:`glmref.judge.arithmetic.newton_sums`.
    """
    n, unit = len(values), flint.arb(flint.fmpq(1, 2**80))
    M = flint.arb_mat(n, n, [flint.arb(y) * unit for row in Y for y in row])
    f = flint.arb_mat(n, 1, [x.ball for x in values])
    zero = flint.arb(0)
    G = flint.arb_mat(
        n, n, [row[j].ball if j in row else zero for row in gradients for j in range(n)]
    )
    steps, product = M * f, M * G
    slacks = []
    for i in range(n):
        total = flint.arb(0)
        for j in range(n):
            total += flint.arb((int(i == j) - product[i, j]).abs_upper())
        slacks.append(_upper(total))
    return [_upper(steps[i, 0]) for i in range(n)], slacks


def coordinates(point: Sequence[Interval]) -> list[Gradient]:
    """Return intervals (n,) as the coordinates of their space, each with its unit gradient."""
    unit = Interval(flint.arb(1))
    return [Gradient(x, {k: unit}) for k, x in enumerate(point)]


def newton(
    function: Callable[[list], list], start: Sequence[Any], over_box: list, steps: int = 8
) -> tuple[list[Interval], flint.arb_mat]:
    """Return a point near the root of a square system, and the inverse Jacobian: not proved.

    Parameters
    ----------
    function : callable
        n values of n unknowns, over intervals.
    start : sequence of fmpq or Interval
        The numbers to begin with, (n,).
    over_box : list
        The function over a small box around them, with derivatives, (n,).
    steps : int
        At most so many steps with the one inverse; the last is the first below 1e-60.

    Raises
    ------
    ZeroDivisionError
        Where the Jacobian is singular.
    """
    n, zero = len(start), Interval(flint.arb(0))
    rows = [_split(x)[1] for x in over_box]
    J = flint.arb_mat(n, n, [by.get(j, zero).ball.mid() for by in rows for j in range(n)])
    inverse, point = J.inv().mid(), [_split(x)[0] for x in start]
    for _ in range(steps):
        values = [_split(x)[0] for x in function([Interval(x) for x in point])]
        move = (inverse * flint.arb_mat(n, 1, values)).entries()
        point = [(x - y).mid() for x, y in zip(point, move, strict=True)]
        if all(abs(y) < 1e-60 for y in move):
            break
    return [Interval(x) for x in point], inverse


class Algebraic(Ring):
    """An irrational number of the package among the numbers of the judge."""

    __slots__ = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = value

    @staticmethod
    def dot(pairs: Iterable[tuple]):
        """Return sum x_i y_i."""
        return as_number(sum_of_products([(as_scalar(x), as_scalar(y)) for x, y in pairs]))

    def __add__(self, other: Number):
        return as_number(self.value + as_scalar(other))

    def __mul__(self, other: Number):
        found = self.value * as_scalar(other)
        if type(found) is Exact and found._q is None and (type(other) is Algebraic or other):
            return Algebraic(found)  # of two numbers that are not 0
        return as_number(found)

    __radd__, __rmul__ = __add__, __mul__

    def __bool__(self) -> bool:
        answer = self.value.is_zero()
        if answer is None:
            raise Undecided("a ball holds 0: nothing is decided")
        return not answer

    def inverse(self):
        """Return 1 / x."""
        return as_number(1 / self.value)

    def conj(self):
        """Return the conjugate."""
        return as_number(self.value.conjugate())

    def sign(self) -> int:
        """Return the sign of a real number."""
        return self.value.sign()


def as_number(x: Any):
    """Return a number of the package as one of :func:`fast_judge`; an exact zero is rational."""
    if isinstance(x, Ball):
        re, im = x.parts()
        return Interval(re) if im.is_zero() else _box()(Interval(re), Interval(im))
    if isinstance(x, int):
        return Fraction(x)
    if isinstance(x, Ring):
        return x
    if not isinstance(x, Exact):
        return Algebraic(x)  # what else mixes with exact numbers and balls
    if x._q is not None:
        return x._q
    return Fraction(0) if x.is_zero() else Algebraic(x)


def as_numbers(M: Iterable[Iterable]) -> list:
    """Return a matrix of numbers of the package as one of :func:`fast_judge`."""
    return [list(map(as_number, row)) for row in M]


def as_scalar(x: Any) -> Any:
    """Return a number of :func:`fast_judge` as one of the package; what is none stays as it is."""
    if isinstance(x, Interval):
        return x.as_ball()
    if isinstance(x, Algebraic):
        return x.value
    if type(x) is Fraction:
        return _exact(int(x.p), int(x.q))
    if type(x) is _element():
        return as_scalar(fast_judge().numbers.narrowest(x))
    if type(x) is _box():
        return Ball.of_parts(x.re.ball, x.im.ball)
    return x if isinstance(x, Ring) else Exact(x)


def over_scalars(function: Callable[[list], Iterable]) -> Callable[[Sequence[Any]], list[Any]]:
    """Return a function of numbers of :func:`fast_judge` as one of numbers and the like."""

    def found(values: Sequence[Any]) -> list[Any]:
        with consulted():
            return [as_scalar(x) for x in function([as_number(x) for x in values])]

    return found


def asked(place: str) -> Callable[..., Any]:
    """Return a function of :func:`fast_judge` as one of numbers of the package.

    Parameters
    ----------
    place : str
        Module and name, such as ``"polynomials.gcd"``. Numbers, also in sequences, are numbers of
        the judge inside and of the package outside; sequences are lists inside and tuples outside.

    Raises
    ------
    ExactnessError
        By the function: for what the judge leaves undecided or refuses.
    """
    module, _, name = place.partition(".")

    def found(*given: Any) -> Any:
        with consulted() as judge:
            try:
                return outward(getattr(getattr(judge, module), name)(*map(inward, given)))
            except Refused as error:
                raise ExactnessError(str(error)) from error

    return found


def inward(x: Any) -> Any:
    """Return numbers of the package, in sequences or alone, as those of :func:`fast_judge`."""
    if isinstance(x, list | tuple):
        return list(map(inward, x))
    return as_number(x) if isinstance(x, Exact | Ball) else x


def outward(x: Any) -> Any:
    """Return numbers of :func:`fast_judge`, in sequences or alone, as those of the package."""
    if isinstance(x, list | tuple | Iterator):
        return tuple(map(outward, x))
    return as_scalar(x) if isinstance(x, Ring | Fraction) else x


@lru_cache(maxsize=4096)
def _exact(p: int, q: int) -> Exact:
    """Return p / q as a number of the package; tables and trees have the same ones often."""
    return Exact(Fraction(p, q))


@cache
def _element() -> type:
    """Return the type of irrational exact numbers of :func:`fast_judge`."""
    return fast_judge().numbers.Element


@cache
def _box() -> type:
    """Return the type of rectangles of :func:`fast_judge`."""
    return fast_judge().numbers.Box


#: Modules of the judge that know no numbers: both copies share their classes.
SHARED = ("refusals", "claims", "rule")


@lru_cache(maxsize=1)
def fast_judge() -> ModuleType:
    """Return the package of the judge over FLINT; its functions are those of ``glmref.judge``."""
    name, folder = "glmref.judge_over_flint", Path(judge.__file__).parent
    spec = importlib.util.spec_from_file_location(
        name, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # of a load that was cut off, by Ctrl-C or the end of a budget, parts would belong to no package
    for part in [x for x in sys.modules if x.startswith(f"{name}.")]:
        del sys.modules[part]
    sys.modules[name] = module
    parts = {part: importlib.import_module(f"{judge.__name__}.{part}") for part in SHARED}
    for part, shared in {**parts, "arithmetic": sys.modules[__name__]}.items():
        sys.modules[f"{name}.{part}"] = shared
        setattr(module, part, shared)
    spec.loader.exec_module(module)
    importlib.import_module(f"{name}.statements")  # and with it all rules
    return module


_ONE_THREAD = RLock()


@contextmanager
def kept_whole() -> Iterator[ModuleType]:
    """Let one thread complete what :func:`fast_judge` keeps, or forget it where it is stopped."""
    with _ONE_THREAD:
        found = fast_judge()
        try:
            yield found
        except (BudgetError, KeyboardInterrupt, MemoryError, RecursionError):
            # a series may have been left half made
            found.proof.record_of.cache_clear()
            raise


@contextmanager
def consulted() -> Iterator[ModuleType]:
    """Work with :func:`fast_judge` at the precision of its intervals.

    Raises
    ------
    BudgetError
        Where the budget in force is spent, see :mod:`glmref.system.budget`.
    """
    with kept_whole() as found, flint.ctx.workprec(PRECISION):
        yield found


def verdict(certificate: Mapping[str, object]) -> tuple[bool, str]:
    """Return (accepted, sentence) of a certificate, judged with FLINT's numbers: `consulted`."""
    with consulted() as found:
        return found.verdict(certificate)


def proof_of(certificate: Mapping[str, object]) -> str:
    """Return what the proof of a certificate may be called: exact, where all it looks at is."""
    with consulted() as found:
        return found.proof.Proof(certificate, found.statements.RULES).proofs()[0]
