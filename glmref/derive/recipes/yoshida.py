"""Yoshida's order-6 composition of seven midpoint steps, solution A, enclosed.

A composition of midpoint steps is the sweep form with r = 1: D holds the step lengths, X is a row
of ones. Symmetry leaves three unknowns; the conditions are those of the trees [oo], [oooo] and
[[o][o]] (:mod:`glmref.judge.enclosed_sweep` says why the third free tree of order 5 is not
needed).
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from ...catalogue.writer import fill
from ...exact import Exact
from ...findings import Proof
from ...prove.enclosure import conditions_of, prove
from ...system.arguments import one_of
from ..ansatz import Ansatz
from ..polish import polish
from .derivation import Derivation, Progress, Statement

OPTIONS: Mapping[str, str] = {"solution": "A"}

#: Yoshida (1990), table 1: w3, w2, w1 of the three solutions.
SOLUTIONS: Mapping[str, tuple[str, str, str]] = {
    "A": ("0.784513610477560", "0.235573213359357", "-1.17767998417887"),
    "B": ("1.43984816797678", "0.00426068187079180", "-2.13228522200145"),
    "C": ("1.44778256239930", "-2.14403531630539", "0.00152886228424922"),
}
_SOURCE: Mapping[str, Any] = {
    "citation": "Yoshida, H., Construction of higher order symplectic integrators, Physics "
    "Letters A 150 (1990), 262-268",
    "doi": "10.1016/0375-9601(90)90092-3",
    "status": "regenerated",
    "bibtex": "@article{yoshida1990,\n  author = {Yoshida, H.},\n  title = {{Construction of "
    "higher order symplectic integrators}},\n  journal = {Physics Letters A},\n  "
    "volume = {150},\n  pages = {262--268},\n  year = {1990},\n  "
    "doi = {10.1016/0375-9601(90)90092-3},\n}",
}


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Enclose one of the three solutions, each to 75 digits.

    Raises
    ------
    UsageError
        For another solution than A, B or C.
    """
    which = one_of("solution", options["solution"], SOLUTIONS)
    progress(which, 0, 1)
    ansatz = Ansatz(
        "yoshida-6-midpoint" if which == "A" else f"yoshida-6-midpoint-{which.lower()}",
        7,
        6,
        (),
        equations=["order [oo]", "order [oooo]", "order [[o][o]]"],
        xi=False,
        parasitism_free=False,
        title=f"Yoshida's composition of order 6, solution {which}: seven implicit midpoint steps",
    )
    document = ansatz.document()
    start = [Exact(Fraction(x)) for x in SOLUTIONS[which]]
    document = fill(document, polish(conditions_of(document).residuals, start))
    enclosure = prove(document)
    document["claims"] = {
        "order": 6,
        "stage-order": 1,
        "explicit": False,
        "symplectic": True,
        "conjugate-symplectic": True,
        "symmetric": True,
    }
    document["source"] = {**_SOURCE, "where": f"table 1, solution {which}, with more digits"}
    progress("done", 1, 1)
    text = (
        f"{document['name']}: exactly one solution within 1e-60 of the digits, "
        f"of order 6; order 7 refuted by {enclosure.next_order:.2e}"
    )
    return Derivation("yoshida6", [document], [Statement(text, Proof.ENCLOSED)])
