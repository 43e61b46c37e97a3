"""Exact numbers: a thin wrapper over python-flint; the only package that imports it.

Two number types share one set of operations, so that the theory is written once:

* :class:`Exact`, an algebraic number (real or complex). Zero is decidable; there is no tolerance.
* :class:`Ball`, a complex interval of :data:`BALL_BITS` bits, for published decimals and for
  enclosures. ``is_zero`` is ``False`` when zero is excluded and ``None`` when it is not.

Mixing the two gives a ball. A Python int or Fraction mixes with both; a float never does.
Reading and writing the text form is the business of :mod:`glmref.exact.expression`.
"""

from .field import BALL_BITS, LIBRARY
from .number import Ball, Exact, ball, exact, isolated_roots, root_of_unity
from .products import sum_of_products
from .relations import RationalCombinations, box, cyclotomic, factorization
from .to_decimals import rounded_decimal

__all__ = [
    "BALL_BITS",
    "LIBRARY",
    "Ball",
    "Exact",
    "RationalCombinations",
    "Scalar",
    "ball",
    "box",
    "cyclotomic",
    "exact",
    "factorization",
    "isolated_roots",
    "root_of_unity",
    "rounded_decimal",
    "sum_of_products",
]

Scalar = Exact | Ball
