"""The finish that undoes the first value of a start exactly, with the digits of the start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .starting import StartingSystem

__all__ = ["inverse_block", "is_inverse", "needed_stages"]


def needed_stages(A: Sequence[Sequence[str]], b: Sequence[str]) -> list[int]:
    """Stages on which a row of weights depends, ascending."""
    waiting = [j for j, x in enumerate(b) if x != "0"]
    found = set(waiting)
    while waiting:
        for j, x in enumerate(A[waiting.pop()]):
            if x != "0" and j not in found:
                found.add(j)
                waiting.append(j)
    return sorted(found)


def inverse_block(opening: Mapping[str, Any]) -> dict[str, Any]:
    """The finish that undoes the first value of a start exactly, with the same digits.

    Solving ``y_1 = y + h b f(Y)``, ``Y = y + h A f(Y)`` for y gives ``Y = y_1 + h (A - 1 b^T)
    f(Y)`` and ``y = y_1 - h b f(Y)``, on the stages that b depends on.
    """
    b = opening["B"][0]
    stages = needed_stages(opening["A"], b)
    rows = [[_difference(opening["A"][i][j], b[j]) for j in stages] for i in stages]
    return {
        "name": f"inverse of the start in the first value, {len(stages)} stages",
        "kind": "runge-kutta",
        "A": rows,
        "b": [_difference("0", b[j]) for j in stages],
    }


def _difference(left: str, right: str) -> str:
    minus = "" if right == "0" else right[1:] if right.startswith("-") else f"-{right}"
    if left == "0" or not minus:
        return minus or left
    return f"{left}{minus}" if minus.startswith("-") else f"{left}+{minus}"


def is_inverse(opening: Mapping[str, Any], closing: Mapping[str, Any]) -> bool:
    """Whether a finish is :func:`inverse_block` of the start, for all values of its digits."""
    wanted = inverse_block(opening)
    if len(closing["A"]) != len(wanted["A"]):
        return False
    pairs = [*zip(closing["A"], wanted["A"], strict=True), (closing["b"], wanted["b"])]
    system = StartingSystem([[*left, *right] for left, right in pairs])
    return all(
        (row[k] - row[k + len(row) // 2]).is_identically_zero()
        for row in system.affine()
        for k in range(len(row) // 2)
    )
