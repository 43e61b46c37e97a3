"""What a recipe returns, and the source records that several recipes share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...findings import Proof

__all__ = ["GROWS", "Derivation", "Progress", "Statement", "derived_source", "thesis_source"]

#: A note that `campaigns/order6/test_measurements.py` compares with the data it names.
GROWS = (
    "On the pendulum from 2.3 radians at h = 0.1 its parasitic part grows more than {} within ten "
    "million steps, although its growth parameters are 0: see data/measurements/long-runs.json."
)

#: Called with (what is done, steps done, steps in all).
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Statement:
    """One thing that was found, and how it was proved."""

    text: str
    proof: Proof


@dataclass(frozen=True)
class Derivation:
    """What a recipe found.

    Attributes
    ----------
        recipe: its name.
        documents: method documents, complete and proved.
        statements: what was proved on the way.
        refused: whether what was asked for does not exist.
    """

    recipe: str
    documents: Sequence[Mapping[str, Any]]
    statements: Sequence[Statement]
    refused: bool = False


_THESIS = (
    "Khan, M. S., G-symplectic partitioned general linear methods for Hamiltonian systems, "
    "MS thesis, COMSATS University Islamabad, Lahore Campus, 2018"
)
_THESIS_BIBTEX = (
    "@mastersthesis{khan2018,\n  author = {Khan, M. S.},\n  title = {{G-symplectic partitioned "
    "general linear methods for Hamiltonian systems}},\n  school = {COMSATS University Islamabad, "
    "Lahore Campus},\n  year = {2018},\n}"
)


def thesis_source(
    where: str, status: str, errata: Sequence[str] = (), notes: str = ""
) -> dict[str, Any]:
    """The source record of the thesis."""
    record: dict[str, Any] = {"citation": _THESIS, "where": where, "status": status}
    if errata:
        record["errata"] = list(errata)
    if notes:
        record["notes"] = notes
    return {**record, "bibtex": _THESIS_BIBTEX}


def derived_source(where: str) -> dict[str, Any]:
    """The source record of a method that was found by a recipe of this package."""
    return {
        "citation": "glmref, derived by `glmref derive` from the conditions of Butcher, J. C. and "
        "Imran, G., Order conditions for G-symplectic methods, BIT Numerical Mathematics 55 "
        "(2015), 927-948",
        "where": where,
        "status": "derived",
    }
