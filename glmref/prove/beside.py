"""What stands beside a tableau, as the judge has it: estimates, sums of rows, the end of b(theta).

The judge decides whether the numbers are all 0; here the first that is not is named.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..catalogue.claims import DENSE_END, EMBEDDED_DIFFERENCE, ROW_SUMS
from ..errors import ExactnessError
from ..exact.judging import as_scalar, consulted, fast_judge
from ..judge.refusals import Refused
from .ranges import Known

#: The end of a sentence about a number, and the number.
Named = tuple[str, Any]


def _estimates(method: Any) -> Iterator[Named]:
    gaps, rows = fast_judge().rules_rows.differences_of(method), method.rows()
    if method.kind != "glm":
        names = [name for name, (_, estimate) in rows.items() for _ in estimate]
        for name, x in zip(names, gaps, strict=True):
            yield f"the weights of the estimate {name} sum to", x
        return
    if not fast_judge().linalg.is_exact([method.declared.get("o", [])]):
        raise ExactnessError("estimates of several values are judged of exact coefficients")
    each = len(gaps) // len(rows)  # in turn for y' = 0 and for y' = 1
    for k, name in enumerate(rows):
        for x in gaps[k * each : (k + 1) * each : 2]:
            yield f"for y' = 0 the solution less the row {name} is", x
    for k, name in enumerate(rows):
        for x in gaps[k * each + 1 : (k + 1) * each : 2]:
            yield f"for y' = 1 the solution less the row {name} is h times", x


def _sums(method: Any) -> Iterator[Named]:
    gaps = fast_judge().document.gaps_of_rows(method)
    if method.kind != "nystrom":
        yield from ((f"row {i} of A sums to c[{i}] +", x) for i, x in enumerate(gaps, 1))
        return
    s = len(method.list("c"))
    for i, x in enumerate(gaps[:s], 1):
        yield f"row {i} of A sums to c[{i}]^2 / 2 +", as_scalar(x) / 2
    yield from ((f"row {i} of A' sums to c[{i}] +", x) for i, x in enumerate(gaps[s:], 1))


def _end(method: Any) -> Iterator[Named]:
    gaps = fast_judge().rules_rows.gaps_of_end(method)
    yield from ((f"b[{i}](1) differs from b[{i}] by", x) for i, x in enumerate(gaps, 1))


#: Claims of truth about what stands beside a tableau: the key of the file, what is known of a file
#: without it, and the numbers that are to be 0.
BESIDE: Mapping[str, tuple[str, Known, Callable[[Any], Iterator[Named]]]] = {
    EMBEDDED_DIFFERENCE.key: (
        "embedded", Known(False, reason="the file gives no embedded rows"), _estimates
    ),
    ROW_SUMS.key: ("c", Known(True), _sums),
    DENSE_END.key: ("dense", Known(False, reason="the file gives no dense output"), _end),
}  # fmt: skip


def known_beside(facts: Any, claim: str) -> Known:
    """Return whether the numbers are all 0: one that is not decides, else one that is open.

    A method is exact whatever stands beside it: then the numbers say whether the answer is.
    """
    key, without, named = BESIDE[claim]
    exact, shared = facts.kernel.exact, facts.shared
    try:
        if not shared.document.get(key):
            return without
        with consulted():
            try:
                method = shared.record(exact).method.for_claim(claim)
                found = list(named(method))
            except Refused:
                if not exact:
                    raise
                exact = False  # what stands beside it holds decimals
                method = shared.record(exact).method.for_claim(claim)
                found = list(named(method))
            values = key == "embedded" and method.kind == "glm"
            if values and method.vectors_to_one("o", consistent=True)[0] is None:
                return Known(False, exact, "the method is not consistent: there are no u and v")
    except (ExactnessError, Refused) as error:
        return Known(None, facts.kernel.exact, str(error))
    gaps = [(text, as_scalar(x)) for text, x in found]
    left = [(text, x) for text, x in gaps if x.is_zero() is not True]
    if not left:
        return Known(True, exact)
    text, gap = next((x for x in left if x[1].is_zero() is False), left[0])
    shown = f"{complex(gap):.6g}".replace("+0j", "")
    return Known(gap.is_zero(), exact, f"{text} {shown}", gap.magnitude())
