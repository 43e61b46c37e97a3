"""Evaluations of splittings in extended phase space, against explicit multistep pairs.

    python -m campaigns.partitioned.extended data/measurements/nonseparable.json

H(q, p) is doubled to H(q, y) + H(x, p), of which both parts have explicit flows: with Q = (q, y)
and P = (p, -x) it is V(Q) + T(P), so that every splitting of the catalogue applies (Pihajoki,
Celest. Mech. Dyn. Astron. 121 (2015), 211-231). The two copies start equal and are not mixed. Tao
(Phys. Rev. E 94 (2016), 043303) binds them, Jayawardana and Ohsawa (Math. Comp. 92 (2023), 251-281)
project on equal copies; both take these evaluations at least for a step of the same splitting.
"""

from __future__ import annotations

import ast
import json
import math
import re
import sys
import tomllib
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments
from glmref.engine.solve import solve
from glmref.measure.work_precision import reference_state
from glmref.problems import problem
from glmref.problems.formula import Formula
from glmref.problems.model import Problem

#: Splittings of order 4, 6, 6, 8 and 8, for any separable Hamiltonian.
METHODS = ("suzuki-verlet-4", "blanes-moan-6", "yoshida-verlet-6", "kahan-li-8", "suzuki-umeno-8")
TOLERANCES = (1e-6, 1e-9)
SCENES = Path(__file__).parents[2] / "docs" / "nonseparable"
#: Steps of the first run, most steps, and the factor between two runs.
_FIRST, _MOST, _FACTOR = 20, 100_000, 1.25


def doubled(one: Problem) -> Problem:
    """Return the separable system of two copies in the variables Q = (q, y), P = (p, -x).

    Parameters
    ----------
    one : Problem
        Hamilton's equations in expressions.
    """
    m, f = one.dimension // 2, one.f
    assert isinstance(f, Formula)
    q_dot, p_dot = f.outputs[:m], f.outputs[m:]
    dq = _rewritten(f, "p", (*q_dot, *p_dot), lambda i: f"-p[{m + i}]" if i < m else f"p[{i - m}]")
    dp = _rewritten(f, "q", (*p_dot, *(f"-({x})" for x in q_dot)), lambda i: f"q[{i}]")
    q, p = one.y0[:m], one.y0[m:]
    return Problem(dq=dq, dp=dp, y0=[*q, *p, *p, *(-q)], t_span=one.t_span, name=f"two {one.name}")


def _rewritten(
    f: Formula, letter: str, outputs: Sequence[str], put: Callable[[int], str]
) -> Formula:
    """Return a formula in the vector ``letter``, with ``put(i)`` for y[i]."""

    class Put(ast.NodeTransformer):
        def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
            assert isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, int)
            return ast.parse(put(node.slice.value), mode="eval").body

    def written(text: str) -> str:
        # names of common subexpressions of their own: both parts stand in one problem
        named = re.sub(r"\b([a-z]+\d+_)", rf"{letter}\1", text)
        return ast.unparse(Put().visit(ast.parse(named, mode="eval")))

    return replace(
        f, outputs=tuple(map(written, outputs)), variables=(letter,), shape=(len(outputs),),
        common=tuple((written(name), written(text)) for name, text in f.common),
    )  # fmt: skip


def evaluations(one: Problem, end: float, method: str) -> dict[float, int | None]:
    """Return the evaluations of both gradients for each tolerance, ``None`` where it is missed."""
    two, m = doubled(one), one.dimension // 2
    exact = reference_state(one, end).state
    found: dict[float, int | None] = dict.fromkeys(TOLERANCES)
    before: tuple[float, float] | None = None
    steps = _FIRST
    while steps <= _MOST and None in found.values():
        run = solve(two, method, h=end / steps, steps=steps)
        y = run.y[-1]
        error = float(np.abs(np.r_[y[:m], y[2 * m : 3 * m]] - exact).max() / np.abs(exact).max())
        # each stage takes one evaluation for T and one for V
        now = math.log(2 * run.evaluations), math.log(error) if error < 1 else 0.0
        for tolerance, known in found.items():
            level = math.log(tolerance)
            if known is None and now[1] <= level and before is not None:
                part = (level - before[1]) / (now[1] - before[1])
                found[tolerance] = round(math.exp(before[0] + part * (now[0] - before[0])))
        before, steps = now, math.ceil(steps * _FACTOR)
    return found


def rows(names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the evaluations on problems, by tolerance and method."""
    scenes = [tomllib.loads(x.read_text(encoding="utf-8")) for x in sorted(SCENES.glob("*.toml"))]
    ends = {x["problem"]["name"]: x["t_end"] for x in scenes if "problem" in x}
    found = []
    for name in names:
        one = problem(name)
        counts = {method: evaluations(one, float(ends[name]), method) for method in METHODS}
        found += [
            {"problem": name, "tolerance": t, "methods": {k: x[t] for k, x in counts.items()}}
            for t in TOLERANCES
        ]
    return found


def main(path: Path) -> None:
    """Measure on the problems of the record, and write them into it."""
    record = json.loads(path.read_text(encoding="utf-8"))
    names = dict.fromkeys(x["problem"] for x in record["evaluations"])
    record["extended"] = rows(list(names))
    path.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
