"""Search for methods whose parasitic parts do not grow at second order: I3 = 0 at every eigenvalue.

``python -m campaigns.second_order_search FILE`` searches and writes ``FILE`` (the one shipped is
``data/measurements/second-order-search.json``). The methods are those of
:mod:`glmref.derive.ansatz`: symmetric, G-symplectic, A lower triangular; V has -1, a pair on the
unit circle, or both. By the trace rule (``docs/modified.md``) the I3 have the sum (2/3) tr A^3, and
those of a pair are equal: ``tr A^3 = 0`` is one condition, I3(-1) = 0 another where there is a
pair too. With *both* the I1 are to vanish as well. A start counts as in
:mod:`campaigns.order8_search`, and where a value is not just carried along (a row of X that is 0);
that nothing was found is no proof.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments
from campaigns.order8_search import LARGEST, SEED, SOLVED, STARTS, start_of, store, told
from glmref.derive.ansatz import Ansatz, Value
from glmref.derive.search import search
from glmref.exact import Exact
from glmref.exact.judging import Fraction as rational
from glmref.exact.judging import consulted, fast_judge, over_scalars
from glmref.prove.enclosure import conditions_of

#: A row of X below this is 0: its value is carried along and seen by no stage.
UNSEEN = 1e-4

_W3, _I, _W3P = Value("exp(2*pi*i/3)"), Value("i"), Value("exp(2*pi*i/3)", 1)
_EVEN, _ODD, _MINUS = Value("-1", 1, 1), Value("-1", 1, -1), Value("-1", -1, 1)

#: Order, stages, values, explicit stages, whether the I1 are to vanish.
ANSATZES: Sequence[tuple[int, int, Sequence[Value], Sequence[int], bool]] = (
    (4, 3, (_EVEN,), (), False),
    (4, 3, (_MINUS,), (), False),
    (4, 3, (_W3,), (), False),
    (4, 4, (_MINUS,), (), False),
    (4, 4, (_W3,), (), False),
    (4, 5, (_MINUS,), (2,), False),
    (4, 5, (_W3,), (2,), False),
    (6, 5, (_MINUS,), (), False),
    (6, 5, (_W3,), (), False),
    (6, 5, (_I,), (), False),
    (6, 5, (_W3, _ODD), (), False),
    (6, 5, (_W3P, _MINUS), (), False),
    (6, 5, (_W3, _ODD), (), True),
    (6, 5, (_W3P, _MINUS), (), True),
    (6, 6, (_W3,), (1,), False),
    (6, 6, (_W3, _ODD), (1,), False),
    (6, 7, (_W3,), (2, 3), False),
)


def second_order(equations: Any, *, both: bool) -> Callable[[list], list]:
    """Return what must vanish beside the equations: tr A^3, and I3(-1) beside a pair.

    Where -1 and a pair are eigenvalues of the ansatz -1 has the last value. With ``both`` the I1
    are to vanish, too; those of a pair are equal and real. Numbers are the judge's.
    """
    judge = fast_judge()
    algebra, V = judge.linalg, equations.V["o"]
    r, dot, apply = len(V), algebra.dot, algebra.apply
    with consulted():
        onto = algebra.diagonal([rational(int(j == r - 1)) for j in range(r)])
        back = algebra.inverse_matrix(algebra.minus(onto, algebra.combine(algebra.identity(r), V)))
        reduced = judge.numbers.as_reals(algebra.minus(back, onto))  # of -1 - V
        turned = judge.numbers.as_reals(algebra.inverse_matrix(V))
    blocks = ([(1, 2)] if r > 2 else []) + ([(r - 1,)] if r != 3 else [])

    def residuals(values: list) -> list:
        m = equations.at(values).part("o")
        found = [judge.numbers.total(row[i] * row[i] * row[i] for i, row in enumerate(m.A))]
        if r == 4:
            stages = [row[-1] for row in m.U]
            for _ in range(2):
                moved = apply(reduced, apply(m.B, stages))
                stages = [x + y for x, y in zip(apply(m.A, stages), apply(m.U, moved), strict=True)]
            found.append(dot(m.B[-1], stages))
        if both:
            series = equations.series(values, 3)
            c, path = (series.stages(judge.trees.read_tree(x)) for x in ("o", "[o]"))
            bend = [x - y * y * rational(1, 2) for x, y in zip(path, c, strict=True)]
            seen = [[dot(b, [x * u[j] for x, u in zip(bend, m.U, strict=True)]) for j in range(r)]
                    for b in m.B]  # fmt: skip
            found += [dot([turned[i][j] for i in k for j in k], [seen[j][i] for i in k for j in k])
                      for k in blocks]  # fmt: skip
        return found

    return residuals


def attempt(
    order: int, stages: int, values: Sequence[Value], explicit: Sequence[int], both: bool
) -> dict[str, Any]:
    """Search one ansatz and say what came out."""
    equations = conditions_of(Ansatz("x", stages, order, values, explicit=explicit).document())
    more, size = second_order(equations, both=both), len(equations.unknowns)

    def residuals(point: list) -> list:
        return [*equations.residuals(point), *more(point)]

    def seen(point: Sequence[float]) -> bool:
        row_of = over_scalars(
            lambda x: itertools.chain(*fast_judge().krawczyk.at_values(equations.X, x))
        )
        X = np.reshape(
            [float(x) for x in row_of([Exact(Fraction(x)) for x in point])], (-1, stages)
        )
        return bool(np.all(np.abs(X).max(axis=1) > UNSEEN))

    ends = list(search(over_scalars(residuals), start_of(size), seed=SEED, starts=STARTS))
    good = [x for x in ends if max(map(abs, x.point)) < LARGEST]
    solved = [x for x in good if x.residual < SOLVED]
    return {
        "order": order,
        "stages": stages,
        "implicit": stages - sum(1 + (2 * k != stages + 1) for k in explicit),
        "values": len(equations.G),
        **told(values),
        "explicit": list(explicit),
        "I1": both,
        "unknowns": size,
        "conditions": len(equations.equations) + len(more([rational(0)] * size)),
        "starts": len(ends),
        "solved": len(solved),
        "unseen": sum(not seen(x.point) for x in solved),
        "smallest_residual": float(f"{min((x.residual for x in good), default=np.inf):.2g}"),
    }


def attempt_case(case: Mapping[str, Any]) -> dict[str, Any]:
    """Search the ansatz of a number."""
    return attempt(*ANSATZES[case["ansatz"]])


def main(path: Path) -> None:
    """Search every ansatz and write the file."""
    title = "No growth of second order: conditions and what random starts gave"
    store(path, "second-order-search", title, attempt_case, len(ANSATZES))


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
