"""Order 4 with four stages and three values: the thesis's (3.8) corrected, S4, and their families.

V = diag(1, z, conj z), G = diag(1, -1/2, -1/2) in the complex form, b = (b1, b2, b2, b1), sum b
omega = 0, so that the abscissae are c = A 1 and y_1 starts as y0; no growth is sum b |omega|^2 =
0.

*thesis* (Khan 2018, section 3.3): omega = (1, omega2, -omega2, -1) and stages 1 and 4 explicit,
for any z and any b1 for which the roots are real. In closed form |omega2|^2 = -b1/b2, c2 = (1 -
sqrt(1 - 1/(3 b2)))/2, a21 = c2 - 1/4 and Re omega2 = 1 - a21/b1. b1 = -169/3360 gives (3.8),
whose a21 = -11/172 is misprinted as -11/72.

*symmetric*: omega_(5-i) = -conj(omega_i), time-symmetric; b1 and beta1 are free, alpha1, alpha2
solve the condition of order 3 and the growth condition. b1 = -1/10, beta1 = 1 gives S4.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from ...catalogue.writer import fill
from ...errors import UsageError
from ...exact import Exact
from ...findings import Proof
from ...prove.enclosure import conditions_of, prove
from ...system.arguments import one_of
from ..polish import polish
from ..recognise import exact_text, surds
from .derivation import Derivation, Progress, Statement, proved_exactly, rational_option
from .sources import derived_source, thesis_source

OPTIONS: Mapping[str, str] = {
    "family": "thesis",
    "b1": "",
    "beta1": "1",
    "start": "0.01,0.37",
}
_DEFAULT_B1 = {"thesis": "-169/3360", "symmetric": "-1/10"}
_V = (("1", "0", "0"), ("0", "-1/2", "-sqrt(3)/2"), ("0", "sqrt(3)/2", "-1/2"))
_G = (("1", "0", "0"), ("0", "-1/4", "0"), ("0", "0", "-1/4"))


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Derive one member of one of the two families.

    Raises
    ------
    UsageError
        For another family, or numbers that are not rational.
    """
    family = one_of("family", options["family"], _DEFAULT_B1)
    b1 = rational_option("b1", options["b1"] or _DEFAULT_B1[family])
    if b1 in (0, Fraction(1, 2)):
        raise UsageError(f"`b1` must not be 0 or 1/2, got {b1}: a weight vanishes")
    progress(family, 0, 1)
    if family == "thesis":
        result = _thesis(b1)
    else:
        result = _symmetric(b1, rational_option("beta1", options["beta1"]), options["start"])
    progress("done", 1, 1)
    return result


def _base(name: str, title: str, b1: Fraction, parity: int) -> dict[str, Any]:
    """Return the parts both families share; ``parity`` is that of Im omega."""
    sign = "" if parity > 0 else "-"
    return {
        "format": "glmref-method-1",
        "name": name,
        "title": title,
        "class": "sweep",
        "constants": {"b1": str(b1), "b2": str(Fraction(1, 2) - b1)},
        "D": ["b1", "b2", "b2", "b1"],
        "X": [
            ["1", "1", "1", "1"],
            ["2*alpha1", "2*alpha2", "-2*alpha2", "-2*alpha1"],
            ["2*beta1", "2*beta2", f"{sign}2*beta2", f"{sign}2*beta1"],
        ],
        "V": [list(row) for row in _V],
        "G": [list(row) for row in _G],
        "claims": {"order": 4},
    }


def _claims(*, symmetric: bool) -> dict[str, Any]:
    return {
        "order": 4,
        "order-identity": 4,
        "g-symplectic": True,
        "symmetric": symmetric,
        "parasitism-free": True,
        "growth": ["0", "0"],
    }


def _thesis(b1: Fraction) -> Derivation:
    b2 = Fraction(1, 2) - b1
    square = 1 - Fraction(1, 3) / b2
    if square < 0 or -b1 / b2 < 0:
        text = f"b1 = {b1}: 1 - 1/(3 b2) = {square} and -b1/b2 = {-b1 / b2} must not be negative"
        return Derivation("order4", [], [Statement(text, Proof.EXACT)], refused=True)
    c2 = (1 - Exact(square).sqrt()) / 2
    alpha2 = 1 - (c2 - Fraction(1, 4)) / b1
    beta_square = -b1 / b2 - alpha2 * alpha2
    if beta_square.sign() < 0:
        text = f"b1 = {b1}: (Im omega2)^2 = {float(beta_square):.6g} is negative"
        return Derivation("order4", [], [Statement(text, Proof.EXACT)], refused=True)
    fixed = b1 == Fraction(-169, 3360)
    name = "thesis-3-8" if fixed else "thesis-order4"
    title = "G-symplectic method of order 4 with four stages, free of parasitism"
    document = _base(name, title, b1, -1)
    constants = {
        "alpha1": "1",
        "alpha2": exact_text(alpha2),
        "beta1": "0",
        "beta2": exact_text(-beta_square.sqrt()),
    }
    document["constants"] |= constants
    document["claims"] = _claims(symmetric=False)
    where = "section 3.3" + (
        ", equation (3.8), in the sweep form" if fixed else f", with b1 = {b1}"
    )
    errata = ("a21 is printed as -11/72; it is -11/172.",) if fixed else ()
    document["source"] = thesis_source(where, "corrected" if fixed else "derived", errata)
    return Derivation("order4", [document], [proved_exactly(document)])


def _symmetric(b1: Fraction, beta1: Fraction, start: str) -> Derivation:
    s4 = (b1, beta1) == (Fraction(-1, 10), Fraction(1))
    name = "s4-symmetric" if s4 else "symmetric-order4"
    title = "Symmetric G-symplectic method of order 4 with four stages, free of parasitism"
    document = _base(name, title, b1, 1)
    beta2 = -b1 * beta1 / (Fraction(1, 2) - b1)
    document["constants"] |= {"beta1": str(beta1), "beta2": str(beta2)}
    document["unknowns"] = {"alpha1": "", "alpha2": ""}
    equations = ["order [oo]", "growth exp(2*pi*i/3)"]
    document["enclosure"] = {"equations": equations, "radius": "1e-60", "xi": {}}
    point = [Exact(Fraction(x)) for x in start.split(",")]
    found = polish(conditions_of(document).residuals, point)
    document = fill(document, found)
    enclosure = prove(document)
    where = f"symmetric family with sum b omega = 0, b1 = {b1}, beta1 = {beta1}"
    closed = surds(dict(zip(("alpha1", "alpha2"), found, strict=True)))
    if len(closed) == 2:
        exactly = {
            k: v for k, v in document.items() if k not in ("digits", "unknowns", "enclosure")
        }
        exactly["constants"] = {**document["constants"], **closed}
        exactly["claims"] = _claims(symmetric=True)
        exactly["source"] = derived_source(where)
        return Derivation("order4", [exactly], [proved_exactly(exactly)])
    claims = _claims(symmetric=True)
    document["claims"] = {k: v for k, v in claims.items() if k != "order-identity"}
    document["source"] = derived_source(where)
    text = (
        f"{name}: exactly one solution within 1e-60 of the digits, "
        f"of order 4; order 5 refuted by {enclosure.next_order:.2e}"
    )
    return Derivation("order4", [document], [Statement(text, Proof.ENCLOSED)])
