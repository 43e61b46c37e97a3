"""Formulas of problems: each is refused with a sentence, or evaluated, differentiated and stepped.

Nothing but arithmetic may come of a formula: a name that is no variable, an attribute, a call of
anything but a function of the list is refused, and a power or a nesting that costs minutes too.
"""

import random
from collections.abc import Iterable
from contextlib import suppress
from typing import Any

import mpmath
import numpy as np

from glmref import Problem, solve

CASES = "problems"
COUNT = 2000
SECONDS = 3.0
ATOMS = (
    "y[0]", "y[1]", "t", "a", "pi", "1", "0", "1/3", "0.1", "1e-3", "2**(1/2)", "-y[0]", "y[0]**2",
    "1e308", "1e400", "1e-400", "9" * 500, "y[0]**999", "y[0]**1001", "2**10**10", "9**9**9**9",
    "y[2]", "y[-1]", "y[10**9]", "y[0][0]", "y", "y[0:1]", "y[a]", "q[0]", "b", "None", "True", "...",
    "1j", "'x'", "b'x'", "f'{t}'", "[1]", "(1,)", "{}", "lambda: 1", "y[0] if t else 1", "t and a", "not t",
    "y[0] < 1", "(t := 1)", "[x for x in y]", "__import__('os').system('true')", "open('/etc/passwd')",
    "y.__class__", "sqrt.__globals__", "().__class__.__bases__", "exec('1')", "print(t)", "sin", "sin()",
    "sin(t, t)", "sin(x=t)", "sin(*y)", "atan2(t, a)", "atan2(t)", "log(0)", "log(-1)", "sqrt(-1)",
    "exp(1e9)", "1/0", "1/(t-t)", "0**-1", "0**0", "(-1)**0.5", "y[0]//2", "y[0]%2", "~1", "1<<9", "1@2",
    "(" * 99 + "1" + ")" * 99, "-" * 3000 + "1", "+".join(["y[0]"] * 3000), "sin(" * 60 + "t" + ")" * 60,
    "(" * 3000, "1 1", "y[0", "", " ", "\n", "y[0]\ny[1]", "y[0]#", "y[0];t", "y\u2080", "１", "\x00", "\ud800",
)  # fmt: skip
GOOD = ("y[0]", "y[1]", "t", "a", "pi", "1", "1/3", "0.1", "y[0]**2", "sin(t)")


def formula(draw: random.Random) -> str:
    """One formula, mostly of sound parts."""
    parts = [
        draw.choice(GOOD if draw.random() < 0.6 else ATOMS)
        for _ in range(draw.choice((1, 2, 3, 5)))
    ]
    text = draw.choice("+-*/").join(parts)
    wrap = draw.choice(
        ("{}", "{}", "sin({})", "sqrt({})", "exp({})", "({})**2", "-({})", "log({})")
    )
    text = wrap.format(text)
    if text and draw.random() < 0.15:
        at = draw.randrange(len(text))
        text = text[:at] + draw.choice("()[]*/+-.,;:'\"_=!@#~ ty0\x00\u202e") + text[at + 1 :]
    return text


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Make a problem and use it."""
    given: dict[str, Any] = {"a": draw.choice((1, "1/3", 0.5, "1e400", "1/0", "x", None, float("nan"), True, [], 10**400))
             if draw.random() < 0.2 else 2}  # fmt: skip
    start = draw.choice(((1.0, 0.5), (0, 0), ("1/3", "a"), (1.0,), (), ("x", 1), (float("nan"), 1)))
    start = (1.0, 0.5) if draw.random() < 0.8 else start
    problem = Problem(f=(formula(draw), formula(draw)), y0=start, parameters=given)
    y, wrong = np.array([0.75, -0.5]), []
    with np.errstate(all="ignore"):
        found = np.full(2, np.nan)
        with suppress(ArithmeticError):  # as Python says that there is no value
            found = np.asarray(problem.f(0.25, y), dtype=float)
            wrong = [] if found.shape == (2,) else [f"f has shape {found.shape}"]
            slopes = np.asarray(problem.jacobian(0.25, y), dtype=float)
            wrong += [] if slopes.shape == (2, 2) else [f"the Jacobian has shape {slopes.shape}"]
        if np.isfinite(found).all():
            exact, rounded = (_values(problem, y, bits) for bits in (70, 53))
            # with every function right to the last bit, doubles may still be this far off
            due = 10 * np.abs(exact - rounded)
            scale = 1 + float(np.abs(found).max())
            if (np.abs(exact - found) > 1e-6 * scale + due).any() and scale < 1e6:
                wrong.append(f"double {found} and 20 digits {exact} differ")
        run = solve(problem, "rk4", h=0.01, steps=3, engine="interpreted")
        if run.completed and not np.isfinite(run.y).all():
            wrong.append("completed and not finite")
    return f"run {run.outcome}", wrong


def _values(problem: Problem, y: np.ndarray, bits: int) -> np.ndarray:
    """The right-hand side at t = 1/4, computed with so many bits."""
    context = mpmath.MPContext()
    context.prec = bits
    found = problem.on(context).f(context.mpf("0.25"), [context.mpf(x) for x in y])
    return np.array([complex(x) for x in found])
