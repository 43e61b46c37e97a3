"""The operator of Krawczyk, and expressions in unknowns (sections 2 and 6)."""

from .arithmetic import Fraction, Gradient, Interval, Ring, newton_sums
from .grammar import decimal_number
from .numbers import around, as_interval, as_real, floor, inverse, is_nil
from .polynomials import derivative, horner
from .refusals import require


def root_in(p, box):
    """Return the one root of p in an interval or a rectangle, by the operator of Krawczyk.

    It maps the box into its interior: m - Y p(m) + (1 - Y p'(X)) (X - m), Y about 1 / p'(m).
    """
    slopes = derivative(p)
    for step in range(12):
        m = box.middle()
        Y = inverse(horner(slopes, m).middle())
        image = m - Y * horner(p, m) + (1 - Y * horner(slopes, box)) * (box - m)
        require(step or image.inside(box), "a box is not shown to hold one root")
        box = image.meet(box)
    return box


class Linear(Ring):
    """An expression c_0 + sum c_k x_k in the unknowns, with exact coefficients; never a number."""

    __slots__ = ("terms",)

    def __init__(self, terms):
        self.terms = terms

    @classmethod
    def made(cls, terms):
        """Return the expression, or the number that it is."""
        terms = {k: x for k, x in terms.items() if not is_nil(x)}
        return cls(terms) if set(terms) - {None} else terms.get(None, Fraction(0))

    def __add__(self, other):
        terms = dict(self.terms)
        for k, x in other.terms.items() if isinstance(other, Linear) else ((None, other),):
            terms[k] = terms.get(k, Fraction(0)) + x
        return Linear.made(terms)

    def __mul__(self, other):
        require(not isinstance(other, Linear), "a product of two expressions in the unknowns")
        return Linear.made({k: x * other for k, x in self.terms.items()})

    __radd__, __rmul__ = __add__, __mul__

    def __eq__(self, other):
        return is_nil(self - other)

    __hash__ = None


def at_values(thing, values):
    """Return expressions, in lists or not, at values of the unknowns."""
    if isinstance(thing, list):
        return [at_values(x, values) for x in thing]
    if not isinstance(thing, Linear):
        return as_real(thing)
    value = Fraction(0)
    for k, x in thing.terms.items():
        value = value + (as_real(x) if k is None else values[k] * as_real(x))
    return value


def only_root(function, published, digits, proof):
    """Return intervals around the one root of `function` near the published numbers (Krawczyk).

    The box X has the half-width `radius` around the published numbers, the centre lies in it, Y
    is the matrix `inverse`. The root must be published rounded to nearest.
    """
    n, radius = len(published), decimal_number(proof["radius"])
    require(n and 0 < radius <= Fraction(1, 10**60), "the radius")
    centre, rows = proof["centre"], proof["inverse"]
    require(isinstance(centre, list) and len(centre) == n, "the centre")
    require(isinstance(rows, list) and len(rows) == n, "the inverse")
    centre = [decimal_number(x) for x in centre]
    away = [abs(x - y) for x, y in zip(centre, published, strict=True)]
    require(max(away) < radius, "the centre lies outside the box")
    Y = []
    for row in rows:
        require(isinstance(row, list) and len(row) == n, "the inverse")
        Y.append([floor(decimal_number(x) * 2**80) for x in row])
    unit = around(Fraction(1))
    box = [Gradient(Interval.ends(x - radius, x + radius), {k: unit})
           for k, x in enumerate(published)]  # fmt: skip
    at_centre = [as_interval(x) for x in function([around(x) for x in centre])]
    over_box = function(box)
    require(len(at_centre) == len(over_box) == n, "there are not as many equations as unknowns")
    by = [x.by if isinstance(x, Gradient) else {} for x in over_box]
    news, slacks = newton_sums(Y, at_centre, by)
    reach, worst = radius + max(away), max(slacks)
    for d, step_, slack in zip(away, news, slacks, strict=True):
        require(d + step_ + slack * reach < radius, "the image does not lie inside the box")
    require(worst < 1, "the map is no contraction")
    error = max(news) / (1 - worst)
    half = Fraction(1, 2 * 10**digits)
    require(max(away) + error <= half, "the digits are not those of the root, rounded")
    return [Interval.ends(x - error, x + error) for x in centre]
