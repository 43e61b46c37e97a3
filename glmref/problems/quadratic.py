"""Problems of any size with quadratic invariants: y' = S(y) C y with S skew, point vortices.

A method is G-symplectic exactly when it keeps such invariants in the sense of G, whatever S is:
these are the problems on which the property is measured.
"""

from __future__ import annotations

from fractions import Fraction
from random import Random

from .formula import Formula
from .loops import QuadraticForm
from .model import Problem
from .ranges import count


def skew_quadratic(dimension: object = 4, seed: object = 1) -> Problem:
    """Equations y' = S(y) C y with random symmetric positive definite C, skew S(y) affine in y.

    All coefficients are short binary fractions, so that the double precision problem is the exact
    one; y^T C y is conserved, and nothing else is. S_ij(y) = s_ij + t_ij y_k with k random.
    """
    d = count(dimension, "dimension", least=2, most=40)
    start = count(seed, "seed", least=0)
    random = Random(start)

    def sixteenths() -> Fraction:
        return Fraction(random.randrange(-16, 17), 16)

    c = [[Fraction(0)] * d for _ in range(d)]
    for i in range(d):
        for j in range(i):
            c[i][j] = c[j][i] = sixteenths() / 2 ** d.bit_length()
    for i in range(d):
        # diagonally dominant, hence positive definite and every solution bounded
        c[i][i] = sum((abs(x) for x in c[i]), Fraction(1))
    gradient = [" + ".join(f"({c[i][j]})*y[{j}]" for j in range(d) if c[i][j]) for i in range(d)]
    rows: list[list[str]] = [[] for _ in range(d)]
    for i in range(d):
        for j in range(i):
            entry = f"(({sixteenths()}) + ({sixteenths()})*y[{random.randrange(d)}])"
            rows[i].append(f"{entry}*z{j}")
            rows[j].append(f"-{entry}*z{i}")
    return Problem(
        name="skew-quadratic",
        source="Butcher, Hewitt, BIT 49 (2009) for the class; coefficients from Random(seed)",
        parameters={"dimension": d, "seed": start},
        f=Formula(
            outputs=tuple(" + ".join(row) for row in rows),
            common=tuple((f"z{i}", text) for i, text in enumerate(gradient)),
        ),
        y0=[sixteenths() for _ in range(d)],
        t_span=(0.0, 10.0),
        quadratic={"C": QuadraticForm.of(c, d)},
        scales={"time": 1.0},
    )


def point_vortices(vortices: object = 4) -> Problem:
    """Vortices in the plane, y = (x, y): not separable, with a quadratic angular impulse.

    Strengths are 1, 1/2, 1, 1/2 ...; in sqrt(strength)-scaled coordinates the system is canonical.
    """
    n = count(vortices, "vortices", least=2, most=12)
    strength = [Fraction(1) if i % 2 == 0 else Fraction(1, 2) for i in range(n)]
    pairs = [(i, j) for i in range(n) for j in range(i)]
    common: list[tuple[str, str]] = []
    for i, j in pairs:
        x, y = f"y[{i}] - y[{j}]", f"y[{n + i}] - y[{n + j}]"
        common += [(f"a{i}_{j}", x), (f"b{i}_{j}", y)]
        common.append((f"w{i}_{j}", f"1/(2*pi*(a{i}_{j}*a{i}_{j} + b{i}_{j}*b{i}_{j}))"))
    rows: list[list[str]] = [[] for _ in range(2 * n)]
    for i, j in pairs:
        rows[i].append(f"- ({strength[j]})*w{i}_{j}*b{i}_{j}")
        rows[j].append(f"+ ({strength[i]})*w{i}_{j}*b{i}_{j}")
        rows[n + i].append(f"+ ({strength[j]})*w{i}_{j}*a{i}_{j}")
        rows[n + j].append(f"- ({strength[i]})*w{i}_{j}*a{i}_{j}")
    distances = []
    for i, j in pairs:
        square = f"(y[{i}] - y[{j}])**2 + (y[{n + i}] - y[{n + j}])**2"
        distances.append(f"- ({strength[i] * strength[j] / 2})*log({square})")
    impulse = {(k, k): strength[k % n] for k in range(2 * n)}
    linear = {
        f"impulse {axis}": " + ".join(f"({strength[i]})*y[{shift + i}]" for i in range(n))
        for axis, shift in (("x", 0), ("y", n))
    }
    return Problem(
        name="point-vortices",
        source="Kirchhoff 1876; Newton, The N-Vortex Problem, Springer 2001, section 2.1",
        parameters={"vortices": n},
        f=Formula(tuple("0 " + " ".join(row) for row in rows), tuple(common)),
        y0=[f"cos(2*pi*{i}/{n})*(1 + {i}/10)" for i in range(n)]
        + [f"sin(2*pi*{i}/{n})*(1 + {i}/10)" for i in range(n)],
        t_span=(0.0, 10.0),
        hamiltonian="(0 " + " ".join(distances) + ")/(2*pi)",
        quadratic={"angular impulse": QuadraticForm(impulse, 2 * n)},
        invariants=linear,
        scales={"time": 1.0},
    )
