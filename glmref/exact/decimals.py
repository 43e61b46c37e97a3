"""How many digits make a decimal exact: one rule for files, imported tables, audited codes."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

#: A decimal with at most this many digits after the point means what it says. One with more is
#: rounded: a table is printed with 12 digits or more because its numbers do not end.
SHORT = 11
#: Digits of the longest rounded decimals; what is longer was written to be exact.
MOST = 150


def is_rounded(places: int) -> bool:
    """Return whether a decimal with this many digits after the point is a rounded number."""
    return places > SHORT


def known_digits(places: Iterable[int]) -> int | None:
    """Return the digits after the point to which rounded decimals are known, all of them alike.

    The last digit printed is often wrong by more than one unit, also that of a double.

    Parameters
    ----------
    places : iterable of int
        Digits after the point of each number.

    Returns
    -------
    int or None
        ``None`` where no decimal is rounded.
    """
    least = min(filter(is_rounded, places), default=None)
    return None if least is None else least - 1


def rounded_places(value: Fraction) -> int | None:
    """Return the digits after the point of a fraction that is a rounded decimal, else ``None``.

    Its denominator has no primes but 2 and 5, and more fives than any fraction that was derived.
    """
    rest, places = value.denominator, {2: 0, 5: 0}
    for prime in places:
        while rest % prime == 0:
            rest //= prime
            places[prime] += 1
    most = max(places.values())
    return most if rest == 1 and is_rounded(places[5]) and most <= MOST else None
