"""An analysis as rows of name and text: the same on a terminal and in a notebook."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from .tables import shown_value

_TITLES = {
    "order_identity": "order with the identity as principal part",
    "order_nystrom": "order on second-order systems",
    "order_embedded": "order of row",
    "order_w": "order with any Jacobian (W-order)",
    "wrong_entry": "what is wrong",
    "order_dense": "order of the dense output",
    "principal": "principal part",
    "order_witness": "why not higher",
    "g_symplectic": "G-symplectic",
    "consistency_witness": "why not consistent",
    "growth_rates": "parasitic rate over |H_pq| where",
    "undecided": "not decided:",
}
_DECISIONS = (
    *("explicit", "preconsistent", "consistent", "zero stable", "G-symplectic", "symmetric"),
    "parasitism free",
)
#: The first step of :func:`glmref.prove.analysis.staircase`.
_NEARLY = re.compile(r"\border (\d+) to (\d\S*?), order ")
#: Residuals up to this size are those of coefficients computed in double precision.
_ROUNDING = 1e-12
_STABILITY = {
    "A": "A-stable",
    "L": "L-stable",
    "real": "real stability interval",
    "imaginary": "imaginary stability interval",
    "periodicity": "periodicity interval",
}
_WHOLE = {"real": "the negative real axis", "imaginary": "the imaginary axis"}
#: What several keys say together.
_TOGETHER = ("error_constants", "error_norm", "quadrature_constant", "order_to_digits")


def analysis_rows(
    record: Mapping[str, Any], measured: Mapping[str, float] | None = None
) -> list[tuple[str, str]]:
    """Return an analysis as lines of name and value; a matrix has a line for each row.

    The record is that of :meth:`glmref.Analysis.as_json`; ``measured`` are ends of stability
    intervals found in floating point, shown where none is proved.
    """
    rows: list[tuple[str, str]] = []

    def put(name: str, value: object) -> None:
        rows.extend(_lines(name, value))

    for key, value in record.items():
        if key == "growth":
            for entry in value:
                for inner, x in entry.items():
                    if inner != "eigenvalue":
                        put(f"growth {inner} at {shown_value(entry['eigenvalue'])}", x)
        elif key == "error_constants":
            rows += _error_constants(record)
        elif key == "stability":
            rows += [(_STABILITY[k], _stability(k, x, measured or {})) for k, x in value.items()]
        elif key == "stability_parts":
            rows += [
                (f"{_STABILITY[k]}, part {n}", _stability(k, x, {}))
                for n, found in value.items()
                for k, x in found.items()
            ]
        elif key == "order":
            put(key, _order(record))
        elif key == "consistent":
            put(key, _consistent(record))
        elif key == "undecided" and consistent_to_digits(record):
            put(_TITLES[key], {k: x for k, x in value.items() if k != "consistent"})
        elif key == "symmetric":
            put(key, _symmetric(value))
            if value["holds"]:
                put(key, {k: x for k, x in value.items() if k != "holds"})
        elif key == "order_proved":
            rows.append(("order proved", _proved(*value)))
        elif key == "modified":
            rows += _modified(value)
        elif key == "implicit_stages":
            rows.append(("implicit stages", "none" if value == [] else shown_value(value)))
        elif key not in ("format", "method", *_TOGETHER):
            put(_TITLES.get(key, key.replace("_", " ")), value)
    return rows


def _lines(name: str, value: object) -> Iterator[tuple[str, str]]:
    """Yield the lines of one value: of a mapping one for each key, of a matrix for each row."""
    if isinstance(value, Mapping):
        for key, x in value.items():
            yield from _lines(name if key == "holds" else f"{name} {key}", x)
    elif isinstance(value, list) and value and all(isinstance(x, list) for x in value):
        yield from ((name if i == 0 else "", shown_value(row)) for i, row in enumerate(value))
    elif (value is not None and value != "") or name in _DECISIONS:
        yield name, shown_value(value)


def consistent_to_digits(record: Mapping[str, Any]) -> bool:
    """Return whether the conditions of order 1, thus of consistency, hold within the digits."""
    return bool(record.get("order_to_digits")) and record["order"] >= 1


def _consistent(record: Mapping[str, Any]) -> object:
    """Return what is decided of consistency, or what holds within the digits."""
    if record["consistent"] is None and consistent_to_digits(record):
        return f"yes to {record['order_to_digits']}, the decimals being rounded"
    return record["consistent"]


def _order(record: Mapping[str, Any]) -> object:
    """Return the order; that within rounding errors first, where the exact one is lower."""
    order, digits = record["order"], record.get("order_to_digits")
    if digits:
        return f"{order} to {digits}, the decimals being rounded"
    near = _NEARLY.search(record.get("order_witness") or "")
    if near and float(near[2]) <= _ROUNDING:
        return f"{near[1]} to {near[2]}, {order} exactly"
    return order


def _symmetric(found: Mapping[str, Any]) -> str:
    """Say whether a method is symmetric, as it stands or in reduced form."""
    if found.get("reduced"):
        return f"yes (in reduced form): {found['why']}"
    return shown_value(found["holds"])


def _proved(lower: int | None, upper: int | None) -> str:
    """Return what is proved of the order, in words."""
    if lower == upper:
        return "nothing" if lower is None else f"exactly {lower}"
    least = "" if lower is None else f"at least {lower}"
    return ", ".join(x for x in (least, "" if upper is None else f"at most {upper}") if x)


def _stability(key: str, value: Any, measured: Mapping[str, float]) -> str:
    if isinstance(value, bool) or key in "AL":
        return shown_value(value)
    if value is None and key in measured:
        return f"{_interval(key, measured[key])}, measured"
    return shown_value(value) if value is None else _interval(key, float(value))


def _interval(key: str, end: float) -> str:
    if math.isinf(end):
        return _WHOLE.get(key, "the imaginary axis")
    if end == 0:
        return "none"
    text = f"{end:.12g}"
    return {"real": f"[-{text}, 0]", "imaginary": f"[-{text} i, {text} i]"}.get(key, f"(0, {text})")


def _error_constants(record: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the residuals one order beyond: how many, the largest, their norm, of a quadrature.

    Sizes are shown, as those in the reason why the order is not higher; the record has the signs.
    """
    residuals, order = record["error_constants"], record["order"]
    wrong = {tree: x for tree, x in residuals.items() if x}
    said = f"none of {len(residuals)} trees" if residuals else "not computed"
    if wrong:
        worst = max(wrong, key=lambda tree: abs(wrong[tree]))
        size = f"{abs(wrong[worst]):.6g}"
        said = f"{len(wrong)} of {len(residuals)} trees, largest {size} at tree {worst}"
    rows = [("residuals at the next order", said)]
    if residuals:
        rows.append(("error constant", f"{record['error_norm']:.6g}, norm of residual / symmetry"))
    if record["quadrature_constant"] is not None:
        power = order + 1
        constant = f"{record['quadrature_constant']:.6g} h^{power} y^({power}), by which the "
        constant += "solution of y' = g(t) exceeds a step"
        rows.append(("", constant))
    return rows


def _modified(found: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what :meth:`glmref.Modified.as_json` gives, or why there is none, as rows."""
    if "why" in found:
        return [("modified equation", found["why"])]
    # not at the top: help and tables are shown without loading the theory
    from ..exact.expression import parse
    from ..theory.backward import Reach
    from ..theory.trees import Tree

    titles = {
        "hamiltonian": "Hamiltonian to order",
        "conjugate_symplectic": "conjugate-symplectic to order",
        "energy": "preserves H to order",
    }
    rows = [(title, Reach(**found[key]).text) for key, title in titles.items()]
    for text, value in found["invariant_terms"].items():
        power = Tree(text).order - 1
        name = f"h^{power} H({text})" if power else f"H({text})"
        rows.append((f"outputs conserve {name} times", value))
    for one in found["parasitic"]:
        for name in ("I3", "I1"):
            at = shown_value(one["eigenvalue"])
            value = complex(parse(one[name]))
            rows.append((f"parasitic {name} at {at}", f"{value if value.imag else value.real:.8g}"))
    return rows
