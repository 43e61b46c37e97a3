"""Give a wrong result the name of its defect.

Three ways, the surest first: the result is one that a usual bug gives (the vectors hold these); the
coefficients, read out of the integrator, differ from the method's at named entries; the size of the
error speaks for a kind of arithmetic. What none of them explains is reported as a plain difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from ..errors import GlmrefError
from .adapters.reference import Adapter
from .faults import NOTES
from .identify import matches
from .probe import read
from .readings import named, without_idle
from .subject import AdapterError, NotOffered, Subject
from .vector_problems import TestProblem, array
from .vectors import Case, Vectors

_SHOWN = 3


def known_bug(found: np.ndarray, case: Case, tolerance: float) -> str:
    """Name the bug whose stored result this is, or ``""``."""
    for flag, wrong in case.wrong:
        if wrong.shape == found.shape and np.abs(wrong - found).max() <= 100 * tolerance:
            return f"it is the result of this bug: {NOTES[flag][0]} ({flag})"
    return ""


def single_precision(found: np.ndarray, right: np.ndarray) -> str:
    """Say that the numbers are the right ones in single precision, or ``""``."""
    if found.shape != right.shape or np.array_equal(right, _single(right)):
        return ""
    near = np.abs(found - right).max() < 1e-5 * np.abs(right).max()
    if near and np.array_equal(found, _single(found)):
        return "every number is a single precision number: the arithmetic is not double"
    return ""


def _single(values: np.ndarray) -> np.ndarray:
    return values.astype(np.float32).astype(float)


def single_clock(subject: Subject, vectors: Vectors, case: Case) -> str:
    """Say that time or step size is held in single precision, or ``""``.

    It is where the step from its value in single precision has the same bits: a right step differs
    by the part that was rounded away, thousands of times the round-off of a double.
    """
    cases = [case] if case.kind == "step" else vectors.cases
    for one in (x for x in cases if x.claim in ("abscissae", "backward")):
        t, h = one.number("t"), one.number("h")
        said = {"step size": (t, float(np.float32(h)))}
        if not one.problem.autonomous:
            said["time"] = (float(np.float32(t)), h)
        for what, (time, size) in said.items():
            if (time, size) != (t, h) and _same_step(subject, vectors, one, (t, h), (time, size)):
                return f"the {what} is held in single precision"
    return ""


def _same_step(subject: Subject, vectors: Vectors, case: Case, *ends: tuple[float, float]) -> bool:
    """Return whether steps from several times and of several sizes have the same bits."""
    try:
        rows = [subject.step(vectors.name, case.problem.problem, t, case.input, h) for t, h in ends]
    except (AdapterError, NotOffered):
        return False
    return all(np.array_equal(row, rows[0]) for row in rows)


def unmoved(found: np.ndarray, case: Case) -> str:
    """Say that a component comes out of a step as it went in, or ``""``."""
    given, right = case.input, case["output"]
    still = [
        k + 1
        for k in range(found.shape[1])
        if found[0, k] == given[0, k] and right[0, k] != given[0, k]
    ]
    return f"component {still[0]} comes out as it went in" if still else ""


def constant_factor(found: np.ndarray, right: np.ndarray, h: float) -> str:
    """Say that the values 2 to r are all the same multiple of the right ones, or ``""``."""
    if found.shape != right.shape or len(right) < 2 or not np.all(right[1:]):
        return ""
    ratios = (found[1:] / right[1:]).ravel()
    if np.ptp(ratios) > 1e-9 * abs(ratios[0]) or abs(ratios[0] - 1) < 1e-6 or not ratios[0]:
        return ""
    names = {h: "h", 1 / h: "1/h", -1.0: "the wrong sign"}
    name = next((text for x, text in names.items() if abs(ratios[0] / x - 1) < 1e-9), "")
    return f"values 2 to r are {ratios[0]:.6g} times the right ones" + (
        f" ({name})" if name else ""
    )


def name_defect(
    subject: Subject, vectors: Vectors, case: Case, found: np.ndarray, tolerance: float
) -> str:
    """Return a sentence on why a step or a run is wrong, or ``""`` where nothing explains it."""
    said = known_bug(found, case, tolerance) or single_precision(found, _right(case))
    if not said and case.kind in ("step", "start"):
        said = constant_factor(found, case["output"], case.number("h"))
    if said or case.kind not in ("step", "trajectory"):
        return said
    if "step" in subject.offers:
        said = single_clock(subject, vectors, case)
        if said:
            return said
    for other, result, allowed in _other_steps(subject, vectors, case):
        said = known_bug(result, other, allowed)
        if said:
            return f"on {other.problem.name} {said}"
    said = unmoved(found, case) if case.kind == "step" else ""
    return said or coefficient_differences(subject, vectors)


def _right(case: Case) -> np.ndarray:
    return case["solution"][-1:] if case.kind == "trajectory" else case["output"]


def _other_steps(
    subject: Subject, vectors: Vectors, case: Case
) -> Iterator[tuple[Case, np.ndarray, float]]:
    """Yield steps of the program in the other cases whose vectors hold wrong results."""
    if "step" not in subject.offers:
        return
    for other in vectors.cases:
        if other is case or other.kind != "step" or not other.wrong or other.claim != "step":
            continue
        try:
            result = subject.step(
                vectors.name, other.problem.problem, other.number("t"), other.input,
                other.number("h"),
            )  # fmt: skip
        except (AdapterError, NotOffered):
            continue
        allowed = (subject.epsilon + subject.tolerance(vectors.name)) * other.number("rounding")
        yield other, result, allowed


def coefficient_differences(subject: Subject, vectors: Vectors) -> str:
    """Read the coefficients and say which entries differ, or ``""``."""
    if "values" not in vectors.document:
        return ""
    try:
        reading = read(subject, vectors.name, int(vectors.document["values"]))
    except GlmrefError:
        return ""
    known = [match.name for match in matches(reading)]
    if known and vectors.name not in known:
        return f"its coefficients are those of {known[0]}"
    wanted, found = _wanted(vectors), reading.blocks
    if any(found[letter].shape != matrix.shape for letter, matrix in wanted.items()):
        points, stages = len(found["A"]), len(wanted["A"])
        more = points - stages
        said = f"the result depends on f at {points} points and the method has {stages} stages"
        iterated = more > 0 and bool(getattr(vectors.method, "implicit_stages", True))
        return f"{said}: its stage equations are iterated and not solved" if iterated else said
    entries = [
        (abs(a - b), f"{letter}[{i + 1}][{j + 1}] is {a:.10g} and must be {b:.10g}{_digits(a, b)}")
        for letter, matrix in wanted.items()
        for i, row in enumerate(matrix)
        for j, b in enumerate(row)
        for a in [found[letter][i, j]]
        if abs(a - b) > 1e-12
    ]
    if not entries:
        return reading.notes[0] if reading.notes else ""
    more = len(entries) - _SHOWN
    rest = f", and {more} more" if more > 0 else ""
    return "its coefficients differ: " + ", ".join(text for _, text in entries[:_SHOWN]) + rest


def _digits(found: float, right: float) -> str:
    """Return a remark that a number is the right one with few digits, or ``""``."""
    for digits in range(3, 13):
        if found == round(right, digits) and found != right:
            return f" ({digits} digits only)"
    return ""


def _wanted(vectors: Vectors) -> dict[str, np.ndarray]:
    """Return coefficients of the method, without stages on which nothing depends."""
    given: Any = vectors.coefficients
    parts = [given["q"], given["p"]] if "q" in given else [given]
    halves = [tuple(array(part[x]) for x in "AUBV") for part in parts]
    left, _ = without_idle([(A, U, B, V) for A, U, B, V in halves])
    return named(left)


def stage_order(found: np.ndarray, expected: np.ndarray, tolerance: float) -> str:
    """Say that the stages are right but in another order, or ``""``."""
    order: list[int] = []
    for row in expected:
        near = [j for j, x in enumerate(found) if np.abs(x - row).max() <= tolerance]
        near = [j for j in near if j not in order]
        if not near:
            return ""
        order.append(near[0])
    if order == list(range(len(order))):
        return ""
    places = ", ".join(str(j + 1) for j in order)
    return (
        f"the stages are right but come in another order: they belong at {places} (StagesReordered)"
    )


def start_order(subject: Subject, vectors: Vectors, task: TestProblem) -> str:
    """Name the order of an adapter's starting values beside those of the data file, or ``""``.

    The difference of starting values of orders q < p is O(h^(q+1)); it is measured at four step
    sizes.
    """
    ours, problem = Adapter((vectors.name,)), task.problem
    shape, gaps = (int(vectors.document["values"]), problem.dimension), []
    try:
        for h in (2.0**-5, 2.0**-6, 2.0**-7, 2.0**-8):
            right = ours.start(vectors.name, problem, h)
            found = subject.start(vectors.name, problem, h, shape)
            gaps.append(float(np.abs(found - right).max()))
    except (GlmrefError, ArithmeticError, NotImplementedError):
        return ""
    if min(gaps) <= 1e3 * subject.unit(vectors.name):
        return ""
    slopes = np.log2(np.array(gaps[:-1]) / np.array(gaps[1:]))
    if abs(slopes[-1] - slopes[-2]) > 0.25:
        return ""
    return (
        f"; its starting values differ from those of the data file like h^{slopes[-1]:.1f}: it is "
        f"a start of order {max(round(slopes[-1]) - 1, 0)}"
    )


def residual_of_stages(vectors: Vectors, case: Case, stages: Sequence[np.ndarray]) -> float:
    """Return largest defect of ``Y = h A f(Y) + U y`` at stage values of an adapter; of a GLM."""
    c = vectors.coefficients
    A, U, t, h = array(c["A"]), array(c["U"]), case.number("t"), case.number("h")
    times = t + array(c["c"]) * h
    f = case.problem.problem.f
    slopes = np.array([f(s, y) for s, y in zip(times, stages[0], strict=True)])
    return float(np.abs(h * A @ slopes + U @ case.input - stages[0]).max())
