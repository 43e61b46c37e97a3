"""The operator of Krawczyk, and expressions in unknowns (sections 2 and 6)."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from .arithmetic import Fraction, Gradient, Interval, Number, Ring, newton_sums
from .grammar import decimal_number
from .numbers import Box, around, as_interval, as_real, floor, inverse, is_nil, total
from .polynomials import derivative, horner
from .refusals import Document, as_list, require


def root_in(p: list, box: Interval | Box) -> Interval | Box:
    """Return the one root of p in an interval or a rectangle, by the operator of Krawczyk.

    It maps the box into its interior: m - Y p(m) + (1 - Y p'(X)) (X - m), Y about 1 / p'(m).
    """
    slopes, region = derivative(p), cast("Interval", box)  # a rectangle has the same methods
    for step in range(12):
        m = region.middle()
        Y = inverse(horner(slopes, m).middle())
        image = m - Y * horner(p, m) + (1 - Y * horner(slopes, region)) * (region - m)
        require(
            step or cast("Interval", image).inside(region), "a box is not shown to hold one root"
        )
        region = cast("Interval", image).meet(region)
    return region


class Linear(Ring):
    """An expression c_0 + sum c_k x_k in the unknowns, with exact coefficients; never a number."""

    __slots__ = ("terms",)

    def __init__(self, terms: dict[int | None, Number]) -> None:
        self.terms = terms

    @classmethod
    def made(cls, terms: dict[int | None, Number]) -> Number:
        """Return the expression, or the number that it is."""
        terms = {k: x for k, x in terms.items() if not is_nil(x)}
        return cls(terms) if set(terms) - {None} else terms.get(None, Fraction(0))

    def __add__(self, other: Number) -> Number:
        terms = dict(self.terms)
        for k, x in other.terms.items() if isinstance(other, Linear) else ((None, other),):
            terms[k] = terms.get(k, Fraction(0)) + x
        return Linear.made(terms)

    def __mul__(self, other: Number) -> Number:
        require(not isinstance(other, Linear), "a product of two expressions in the unknowns")
        return Linear.made({k: x * other for k, x in self.terms.items()})

    __radd__, __rmul__ = __add__, __mul__

    def __eq__(self, other: Number) -> bool:
        return is_nil(self - other)

    __hash__ = None  # type: ignore[assignment]


def at_value(x: Number, values: list) -> Number:
    """Return an expression at values of the unknowns."""
    if not isinstance(x, Linear):
        return as_real(x)
    return total(as_real(y) if k is None else values[k] * as_real(y) for k, y in x.terms.items())


def at_values(thing: list, values: list) -> list:
    """Return expressions in a vector or matrix at values of the unknowns."""
    return [at_values(x, values) if isinstance(x, list) else at_value(x, values) for x in thing]


def box_around(published: list[Fraction], radius: Fraction) -> list[Gradient]:
    """Return the box X of this half-width, each number with its derivative by itself."""
    unit = around(Fraction(1))
    return [Gradient(Interval.ends(x - radius, x + radius), {k: unit})
            for k, x in enumerate(published)]  # fmt: skip


def only_root(
    function: Callable[[list], list],
    published: list[Fraction],
    digits: int,
    proof: Document,
    over_box: Callable[[], list],
) -> list[Interval]:
    """Return intervals around the one root of `function` near the published numbers (Krawczyk).

    The box X has the half-width `radius` around the published numbers, the centre lies in it, Y
    is the matrix `inverse`. The root must be published rounded to nearest. `over_box` gives
    `function` at :func:`box_around`.
    """
    n, radius = len(published), decimal_number(proof["radius"])
    require(n and 0 < radius <= Fraction(1, 10**60), "the radius")
    centre = [decimal_number(x) for x in as_list(proof["centre"], "the centre")]
    rows = [as_list(row, "the inverse") for row in as_list(proof["inverse"], "the inverse")]
    require(len(centre) == n, "the centre")
    require(len(rows) == n and all(len(row) == n for row in rows), "the inverse")
    away = [abs(x - y) for x, y in zip(centre, published, strict=True)]
    require(max(away) < radius, "the centre lies outside the box")
    Y = [[floor(decimal_number(x) * 2**80) for x in row] for row in rows]
    at_centre = [as_interval(x) for x in function([around(x) for x in centre])]
    image = over_box()
    require(len(at_centre) == len(image) == n, "there are not as many equations as unknowns")
    by = [x.by if isinstance(x, Gradient) else {} for x in image]
    news, slacks = newton_sums(Y, at_centre, by)
    reach, worst = radius + max(away), max(slacks)
    for d, step_, slack in zip(away, news, slacks, strict=True):
        require(d + step_ + slack * reach < radius, "the image does not lie inside the box")
    require(worst < 1, "the map is no contraction")
    error = max(news) / (1 - worst)
    half = Fraction(1, 2 * 10**digits)
    require(max(away) + error <= half, "the digits are not those of the root, rounded")
    return [Interval.ends(x - error, x + error) for x in centre]
