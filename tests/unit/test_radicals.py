"""Numbers as elements of the fields of certificates and of proofs for Coq.

What an element means is computed here in another way: every generator is the principal root of its
radicand, as complex numbers with 40 digits.
"""

import re
import subprocess
import sys
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from glmref.errors import ExactnessError
from glmref.exact import Exact
from glmref.exact.expression import parse
from glmref.prove import field
from tests.build import refused

NUMBERS = (
    "3/7", "sqrt(2)", "1/(1+sqrt(2))", "sqrt(2/3)-sqrt(6)", "root(2,3)/(1+sqrt(5))", "i*sqrt(3)-1",
    "sqrt(3/7+2/7*sqrt(6/5))", "(1+sqrt(2))*root(3,3)", "1/root(2,5)", "sqrt(1+i)", "exp(2*pi*i/3)",
    "sqrt(2)*(1+i)/2", "root(4,3)+root(2,3)",
)  # fmt: skip


def close(x: Any, y: Any) -> bool:
    return abs(x - y) < mpmath.mpf(10) ** -30


def number(text: str, **names: Any) -> Any:
    """Value of an expression with sqrt, root, i and exp, in mpmath alone."""
    names |= {
        "sqrt": mpmath.sqrt,
        "root": lambda x, n: mpmath.root(x, int(n)),
        "exp": mpmath.exp,
        "pi": mpmath.pi,
        "i": mpmath.mpc(0, 1),
        "mpf": mpmath.mpf,
    }
    return eval(re.sub(r"(?<![\w])(\d+)", r"mpf(\1)", text), {"__builtins__": {}}, names)


@pytest.fixture(autouse=True)
def digits() -> Any:
    with mpmath.workdps(40):
        yield


@pytest.mark.parametrize("text", NUMBERS)
@pytest.mark.parametrize("restricted", [False, True])
def test_coordinates_are_those_of_the_number(text: str, restricted: bool) -> None:
    """Products of principal roots with these weights; and in a field with more radicals than it."""
    radicals = field.radicals_of(text)
    others = ["sqrt(7)"] if restricted else []
    tower = field.Tower([*others, *radicals], conjugates=False)
    value = parse(text)
    assert isinstance(value, Exact)
    found = tower.coordinates(value, radicals if restricted else ())
    total = mpmath.mpc(0)
    for powers, weight in found.items():
        term = mpmath.mpf(weight.numerator) / weight.denominator
        for x, k in zip(tower.values, powers, strict=True):
            term *= mpmath.mpmathify(complex(x)) ** k
        total += term
    assert abs(total - number(text)) < 1e-12
    exact = Exact(0)
    for powers, weight in found.items():
        product = Exact(weight)
        for x, k in zip(tower.values, powers, strict=True):
            product = product * x**k
        exact = exact + product
    assert (exact - parse(text)).is_zero() is True


@pytest.mark.slow
def test_large_weights_are_found_with_more_bits() -> None:
    tower = field.Tower(["sqrt(2)", "root(3,3)"])
    value = Exact(2).sqrt() * Fraction(10**400 + 7, 3**300) + parse("root(3,3)") / 11
    found = tower.coordinates(value)
    assert found[1, 0] == Fraction(10**400 + 7, 3**300)
    assert found[0, 1] == Fraction(1, 11)
    refused(ExactnessError, "outside the field", tower.coordinates, Exact(5).sqrt())


FIELDS = (
    "sqrt(12)+sqrt(27)*sqrt(1/3)+i*sqrt(3)", "sqrt(3/7+2/7*sqrt(6/5))+exp(2*pi*i/5)",
    "sqrt(-3/4)*root(2,3)+sqrt(-5)", "sqrt(sqrt(2))+root(5,3)+sqrt(0)", "sqrt(-4)*sqrt(-1-sqrt(2))",
    "sqrt(10)+sqrt(15)+sqrt(6)", "sqrt(3+2*sqrt(2))+sqrt(18)", "root(3+sqrt(7),3)*exp(2*pi*i/3)",
)  # fmt: skip


def roots_of(coefficients: list[Any]) -> list[Any]:
    """Roots of a polynomial without multiple ones, lowest coefficient first, by Newton's method.

    The functions of mpmath take the highest first before 1.4 and warn of that from then on.
    """

    def step(x: Any) -> Any:
        value = slope = mpmath.mpf(0)
        for c in reversed(coefficients):
            value, slope = value * x + c, slope * x + value
        return x - value / slope

    found = [mpmath.mpc(x) for x in np.roots([complex(x) for x in reversed(coefficients)])]
    for _ in range(6):  # each doubles the digits: 15 at first, more than 500 then
        found = list(map(step, found))
    return found


@pytest.mark.parametrize("text", FIELDS)
def test_radicals_are_written_in_generators_that_are_isolated(text: str) -> None:
    """Each generator is the one root of its polynomial in its box; radicals are those numbers."""
    radicals = field.radicals_of(text)
    tower = field.Tower(radicals)
    found = tower.as_json()
    names: dict[str, Any] = {}

    for entry, exact in zip(found["generators"], tower.values, strict=True):
        left, right, low, high = (number(x) for k in ("real", "imag") for x in entry[k])
        coefficients = [number(x, **names) for x in entry["polynomial"]]
        roots = roots_of([*coefficients, 1])
        slack = mpmath.mpf(10) ** -30
        inside = [
            x for x in map(mpmath.mpc, roots)
            if left <= x.real <= right and low - slack <= x.imag <= high + slack
        ]  # fmt: skip
        assert exact.is_real() == (low == high == 0)
        (root,) = inside
        names[entry["name"]] = root
        if "conjugate" in entry:
            assert close(number(entry["conjugate"], **names), mpmath.conj(root))
        else:
            assert exact.is_real()
    assert set(found["radicals"]) == set(radicals)
    for radical, written in found["radicals"].items():
        assert close(number(written, **names), number(radical)), radical


def test_a_field_has_no_more_generators_than_it_needs() -> None:
    for text, degrees in (
        ("sqrt(10)+sqrt(15)+sqrt(6)", [2, 2]),
        ("sqrt(3+2*sqrt(2))", [2]),  # 1 + sqrt(2)
        ("sqrt(-1)+i+sqrt(-9/4)", [2]),
        ("exp(2*pi*i/3)*sqrt(-3)", [2, 2]),
        ("root(8,3)", []),
    ):
        tower = field.Tower(field.radicals_of(text))
        assert tower.degrees == degrees, text
    assert field.Tower([]).as_json() == {"kind": "rational"}


def test_a_radicand_that_cannot_be_factored_is_a_generator() -> None:
    """Factoring the product of these primes would take years, and no budget ends it."""
    N = (2**521 - 1) * (2**607 - 1)
    tower = field.Tower([f"sqrt({12 * N})", f"sqrt({N}/3)", f"sqrt({N**2})"])
    assert [x["polynomial"] for x in tower.generators] == [[str(-3 * N), "0"]]
    assert list(tower.radicals.values()) == ["2*g1", "1/3*g1", str(N)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "N",
    ["(2**521 - 1) * (2**607 - 1)", "(2**607 - 1) * (2**1279 - 1)", "(2**341 - 1) * (2**487 - 1)",
     "2**122 + 1", "2**128 - 2", "2**254 - 1", "Fraction(2**126 + 1, 2**126)"],
)  # fmt: skip
def test_a_square_root_next_to_a_short_dyadic_number_is_enclosed(N: str) -> None:
    """In a child: flint refines its ball of some of these numbers without end."""
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_CPU, (9, 9))\n"
        "from fractions import Fraction\n"
        "from glmref.exact import Exact\n"
        f"N = Exact({N})\n"
        "x = N.sqrt()\n"
        "y = N.root(2) + Exact(2).sqrt()\n"
        "print(x.ball(64).contains(x.ball(4096)), (1 + x).sign(), (x * x - N).is_zero())\n"
        "print(y.ball(64).contains(y.ball(4096)), (3 + x).sqrt().sign())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300, check=True
    )
    assert done.stdout.split() == ["True", "1", "True", "True", "1"]


def test_numbers_outside_a_field_and_fields_too_large_are_refused() -> None:
    tower = field.Tower(["sqrt(2)"])
    assert tower.element(Exact(2).sqrt() * 3 - 1) == "-1+3*g1"
    assert tower.element(Exact(0)) == "0"
    refused(ExactnessError, "outside the field", tower.element, Exact(3).sqrt())
    primes = (2, 3, 5, 7, 11, 13)
    assert len(field.Tower([f"sqrt({p})" for p in primes]).degrees) == 6  # degree 64
    refused(ExactnessError, "degree 128", field.Tower, [f"sqrt({p})" for p in (*primes, 17)])
    refused(ExactnessError, "conjugation", field.Tower, ["i", "sqrt(1+i)"])
