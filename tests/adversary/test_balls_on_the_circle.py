"""A product of moduli that is exactly 1 does not say that an eigenvalue lies outside."""

from __future__ import annotations

from .deceive import Verdict, doc, verdicts


def test_a_rotation_in_decimals_is_open() -> None:
    """Characteristic polynomial w^2 - 2 c w + 1 with c a ball: both roots on the circle."""
    d = doc(
        "glm",
        {"zero-stable": True},
        A=[["0"]], U=[["1", "0", "0"]], B=[["1"], ["0"], ["0"]],
        V=[["1", "0", "0"], ["0", "0", "-1"], ["0", "1", "0.500"]],
        digits=3,
    )  # fmt: skip
    assert verdicts(d)["zero-stable"] is Verdict.OPEN
    d["V"][2][1] = "1.125"
    assert verdicts(d)["zero-stable"] is Verdict.FAILS
