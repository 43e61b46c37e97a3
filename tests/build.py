"""Documents of methods, and functions of users, that tests make up."""

import json
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import strategies as st

from glmref.exact import exact, linalg
from glmref.exact.linalg import Matrix
from glmref.method import GLM, as_matrix

#: Where a made-up method comes from.
SOURCE = {"citation": "a test", "where": "here", "status": "derived"}

#: Small sources of other codes, and the cases of the audit.
SOURCES = Path(__file__).with_name("sources")


def method_document(kind: str, claims: Mapping[str, Any], **keys: Any) -> dict[str, Any]:
    """Return a method document with these claims."""
    head = {"format": "glmref-method-1", "name": "made-up", "class": kind}
    return {**head, **keys, "claims": dict(claims), "source": SOURCE}


@st.composite
def invertible(draw: st.DrawFn, r: int, largest: int = 2) -> Matrix:
    """Random integer matrix of determinant 1 or -1, times a rational: T = L P R."""
    small = st.integers(-largest, largest)
    lower = [[draw(small) if j < i else int(i == j) for j in range(r)] for i in range(r)]
    upper = [[draw(small) if j > i else int(i == j) for j in range(r)] for i in range(r)]
    order = draw(st.permutations(range(r)))
    scale = draw(st.sampled_from(["1", "-2", "3/5"]))
    first = as_matrix([lower[i] for i in order], "T")
    factor = as_matrix([[scale]], "scale")[0][0]
    return linalg.scale(exact(factor), linalg.matmul(first, as_matrix(upper, "T")))


def same(a: Matrix, b: Matrix) -> bool:
    """Whether two matrices are equal, entry by entry."""
    return all(x == y for r, s in zip(a, b, strict=True) for x, y in zip(r, s, strict=True))


def floats(matrix: Iterable[Iterable[Any]]) -> np.ndarray:
    """Return a matrix of numbers of any kind in doubles."""
    return np.array([[float(x) for x in row] for row in matrix])


def conjugated_rk4() -> GLM:
    """Euler with step h/3 backwards, RK4, Euler with step h/3 forwards, as one tableau."""
    half, b = Fraction(1, 2), [Fraction(1, 6), Fraction(1, 3), Fraction(1, 3), Fraction(1, 6)]
    rk = [[0, 0, 0, 0], [half, 0, 0, 0], [0, half, 0, 0], [0, 0, 1, 0]]
    rows = [[Fraction(-1, 3), 0, 0, 0, 0, 0]]
    rows += [[Fraction(-1, 3), *row, 0] for row in rk]
    rows += [[Fraction(-1, 3), *b, 0]]
    return GLM(A=rows, U=[[1]] * 6, B=[[Fraction(-1, 3), *b, Fraction(1, 3)]], V=[[1]])


def source(name: str) -> str:
    """Return a small source of another code, as the audit reads them, from ``tests/sources``."""
    return (SOURCES / name).read_text(encoding="utf-8")


def scene_text(
    name: str,
    problem: str = 'name = "harmonic-oscillator"',
    answer: str = 'kind = "ended"',
    **keys: Any,
) -> str:
    """Return the text of a scene: keys in TOML, as JSON writes them too, and two tables."""
    head = {
        "format": "glmref-scene-1",
        "name": name,
        "title": f"A {name} scene",
        "question": "Does it work?",
    }
    lines = [f"{key} = {json.dumps(value)}" for key, value in (head | keys).items()]
    return "\n".join([*lines, "", "[problem]", problem, "", "[answer]", answer, ""])


def tower_of_root(n: int, low: str, high: str) -> dict[str, Any]:
    """Return a field as certificates have it, with sqrt(n) between two numbers as generator."""
    generator = {"name": "g1", "polynomial": [str(-n), "0"]}
    generator |= {"real": [low, high], "imag": ["0", "0"]}
    return {"kind": "tower", "generators": [generator], "radicals": {f"sqrt({n})": "g1"}}


def high(digits: int = 40) -> Any:
    """Return an mpmath context of so many digits."""
    context = mpmath.MPContext()
    context.dps = digits
    return context


def in_place(t: float, y: np.ndarray) -> np.ndarray:
    """Return the slope of an oscillator in the array of its argument."""
    held = y[0]
    y[0] = y[1]
    y[1] = -held
    return y


def sharing(held: Any) -> Callable[..., Any]:
    """Return an oscillator that returns one buffer again and again."""

    def f(t, y):
        held[0], held[1] = y[1], -y[0]
        return held

    return f


def refused(
    error: type[Exception] | tuple[type[Exception], ...],
    sentence: str,
    call: Callable[..., object],
    /,
    *arguments: Any,
    **options: Any,
) -> str:
    """Assert that a call is refused in one sentence that has this pattern in it; return the sentence."""
    with pytest.raises(error, match=sentence or None) as caught:
        call(*arguments, **options)
    said = str(caught.value)
    assert "\n" not in said
    return said
