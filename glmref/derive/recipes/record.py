"""What a recipe returns, and the source records that several recipes share."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from ...catalogue.lookup import data_root
from ...catalogue.reader import load_document
from ...errors import ExactnessError, UsageError
from ...findings import Proof, Verdict
from ...prove.facts import facts_of

#: A note that `campaigns/order6/test_measurements.py` compares with the data it names.
GROWS = (
    "On the pendulum from 2.3 radians at h = 0.1 its parasitic part grows more than {} within ten "
    "million steps, although its growth parameters are 0: see data/measurements/long-runs.json."
)

#: A note that `campaigns/partitioned/test_kepler_long.py` compares with the data it names.
GROWS_ON_KEPLER = (
    "Over ten million steps from its default start its energy error or its carried values grow on "
    "Kepler's problem with eccentricity {}, see data/measurements/kepler-long.json."
)
GROWS_LATER_ON_KEPLER = (
    "Over a hundred million steps from its default start its energy error or its carried values "
    "grow on Kepler's problem with eccentricity {}, see data/measurements/kepler-long.json."
)
#: Eccentricities at which that is so, by method.
_ON_KEPLER: Mapping[str, str] = {
    "pair-4-4": "0.1 and 0.3 (the orbit is lost at 0.1)",
    "pair-4-5": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "pair-4-6": "0.1 and 0.3 (the orbit is lost at 0.1 and 0.3)",
    "pair-6-8": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "pair-6-9": "0.6",
    "pair-8-24": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "pair-rkn-6-7": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "pair-rkn-6-7b": "0.1, 0.3 and 0.6",
    "pair-rkn-6-8": "0.6",
    "pair-rkn-6-8b": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "pair-rkn-6-9": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "g6245": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "g6245-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "c2-3-10-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "s5t-w3": "0.1 and 0.3 (the orbit is lost at 0.1)",
    "s5i2-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "s5i1-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "s5i1-i": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "s4-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "s3-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "s3i1-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "t115-i": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "t115-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "t115a-i": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "t115a-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "order8-s5-w3": "0.1 and 0.3 (the orbit is lost at 0.1)",
    "order8-s5a-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "order8-s5q3-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "order8-s5i1-w3": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1, 0.3 and 0.6)",
    "order8-s3-w3-i": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
    "order8-s4i2-w3-i": "0.1, 0.3 and 0.6 (the orbit is lost at 0.1 and 0.3)",
}
_LATER_ON_KEPLER: Mapping[str, str] = {"pair-6-10": "0.1 and 0.3"}

#: A note that `campaigns/test_long_survey.py` compares with the data it names.
GROWS_IN_SURVEY = (
    "Over ten million steps from its default start its energy error grows, at one or more of three "
    "step sizes, on {}, see data/measurements/long-survey.json."
)


@cache
def _in_survey() -> Mapping[str, str]:
    """Problems of the survey on which a run of ten million steps is not bounded, by method."""
    path = data_root() / "measurements" / "long-survey.json"
    where: dict[str, list[str]] = {}
    for row in json.loads(path.read_text(encoding="utf-8"))["rows"]:
        ends = {run["verdict"] for run in row["runs"] if not run["renew"]}
        if row["steps"] == 10_000_000 and ends & {"grows", "lost"}:
            said = row["problem"] + " (lost)" * ("lost" in ends)
            where.setdefault(row["method"], []).append(said)
    return {name: "; ".join(problems) for name, problems in where.items()}


def survey_notes(name: str) -> list[str]:
    """Return the note on ten million steps of eight problems for a method file, or nothing."""
    return [GROWS_IN_SURVEY.format(_in_survey()[name])] if name in _in_survey() else []


def kepler_notes(name: str) -> list[str]:
    """Return the note on long runs of Kepler's problem for a method file, or nothing.

    Returns
    -------
    list of str
        A note where ten million steps of some run are not bounded, and one where a hundred million
        are not.
    """
    kinds = ((GROWS_ON_KEPLER, _ON_KEPLER), (GROWS_LATER_ON_KEPLER, _LATER_ON_KEPLER))
    return [text.format(where[name]) for text, where in kinds if name in where]


#: Called with (what is done, steps done, steps in all).
Progress = Callable[[str, int, int], None]


@cache
def stored(name: str) -> Any:
    """A table of numbers beside the recipes: a JSON file of this folder."""
    return json.loads(files("glmref.derive.recipes").joinpath(name).read_text(encoding="utf-8"))


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
    recipe : str
        Its name.
    documents : Sequence[Mapping[str, Any]]
        Method documents, complete and proved.
    statements : Sequence[Statement]
        What was proved on the way.
    refused : bool
        Whether what was asked for does not exist.
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


def prove_claims(name: str, document: Mapping[str, Any]) -> None:
    """Prove every claim of a method document.

    Raises
    ------
    ExactnessError
        For the first claim that is not proved.
    """
    facts = facts_of(load_document(document))
    for claim, declared in document["claims"].items():
        if facts.judge(claim, declared).verdict is not Verdict.HOLDS:
            raise ExactnessError(f"{name}: the claim {claim} = {declared} is not proved")


def shipped_names(name: str, shipped: Mapping[str, Any]) -> list[str]:
    """Return the one name that is given, or all names of shipped methods.

    Raises
    ------
    UsageError
        For a name that is not shipped.
    """
    if name and name not in shipped:
        raise UsageError(f"`name` must be one of {', '.join(shipped)}, got {name!r}")
    return [name] if name else list(shipped)


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
