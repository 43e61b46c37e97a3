"""A table of coefficients as a reader finds it."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from ..exact import Exact
from .values import Number, Sparse, Unread

Rows = list[list[Number]]


@dataclass
class Table:
    """A table that was found."""

    #: What the code calls it, and where it begins.
    name: str
    line: int
    #: ``"rk"``, ``"additive"``, ``"rosenbrock"``, ``"splitting"``, ``"composition"`` (a splitting,
    #: too), ``"nystrom"``, ``"glm"``.
    kind: str = "rk"
    #: Of each part; of a Rosenbrock method alpha and gamma are two entries of ``A``, of a Nystrom
    #: method A, maybe A', and b, b'; of a general linear method b holds F B and the weights of r -
    #: 1 other values that are the solution.
    A: list[Rows] = field(default_factory=list)
    b: list[list[Number]] = field(default_factory=list)
    c: list[list[Number] | None] = field(default_factory=list)
    order: int | None = None  #: The order that the code declares, or ``None``.
    #: A lower and a higher declared order, where it is not said which row has which.
    pair: tuple[int, int] | None = None
    doubt: str = ""  #: Why the declared order may not be meant as that of b, or ``""``.
    #: Further weights, each with what it is called and its declared order.
    rows: list[tuple[str, list[Number], int | None]] = field(default_factory=list)
    #: Weights of error estimates, which sum to zero.
    errors: list[list[Number]] = field(default_factory=list)
    #: Coefficients of theta, theta^2, .. of b(theta) by stages, each matrix with its name.
    dense: list[tuple[str, Rows]] = field(default_factory=list)
    unread: str = ""  #: Why nothing could be read, or ``""``.
    #: Whether entries stand under names of their own, so that one may have none.
    named: bool = False
    #: Whether it was recognised by what it is; then a verdict is given only where it is sure that
    #: matrix, weights and order are meant as such.
    general: bool = False
    sure: bool = True
    guessed: bool = False  #: Whether its weights are a row of A because no others are read.
    last: int = 0  #: Its last line, where that is known.
    block: Any = None  #: Where a general table stands.
    source: str = ""  #: Name of its matrix.
    computed: bool = False  #: Whether the arithmetic of a step has these numbers.
    #: Whether every statement of a step that is given its slopes was followed.
    followed: bool = True
    loose: int = 0  #: Its order through 3, loosely.
    key: tuple[float, ...] = ()  #: Entries of its matrix that are not zero.
    #: Equations beside the conditions, as "U S = 1", each with its largest residual.
    identities: list[tuple[str, float]] = field(default_factory=list)


ZERO = Number(Exact(0))
#: Source of a table that is read from the arithmetic of a step.
STEP = "#step"


def vector(value: Any, s: int = 0) -> list[Number]:
    """Return a flat list of numbers, with zeros to the length s."""
    if isinstance(value, Sparse):
        return [value.entries.get((k,), ZERO) for k in range(s)]
    flat: list[Number] = []

    def add(x: Any) -> None:
        if isinstance(x, list):
            for y in x:
                add(y)
        elif isinstance(x, Number):
            flat.append(x)
        else:
            raise Unread("an array holds what is no number")

    add(value)
    return [*flat, *([ZERO] * (s - len(flat)))]


def as_composition(first: list[Number], second: list[Number]) -> Table | None:
    """Return the steps of a splitting as a composition of Störmer's method, if they are one.

    That is, the second flow has the weights, one less, of which one is below 0, and the first the
    means of neighbours; where the sum of the cubes is 0 they have order 4, and are a splitting.
    """
    sizes = [complex(x.value).real for x in second]
    if len(first) != len(second) + 1 or len(second) < 3 or min(sizes) >= 0:
        return None
    found = of_weights("", 0, second)
    gaps = [complex(p.value - q.value) for p, q in zip(found.b[0], first, strict=True)]
    return found if abs(sum(x**3 for x in sizes)) > 1e-9 and max(map(abs, gaps)) < 1e-12 else None


def of_weights(name: str, line: int, weights: list[Number]) -> Table:
    """Return Störmer's method composed with weights: half a drift, a kick, half a drift each.

    A step h of a symmetric method of order 2 is replaced by steps w_1 h, .., w_m h. With the sum 1
    and a palindrome the composition has order 4 exactly if the sum of the w_i^3 is 0 (Suzuki 1990;
    Yoshida 1990). The base method of each code is another one; on Störmer's method the order
    conditions are those of any symmetric base of order 2.
    """
    half = [weights[0].of(x.value / 2, x) for x in weights]
    drifts = [half[0], *(x.of(x.value + y.value, y) for x, y in pairwise(half)), half[-1]]
    kicks = [*weights, Number(Exact(0))]
    return Table(name, line, "composition", b=[drifts, kicks])
