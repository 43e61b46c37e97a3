"""What a recipe returns, and the source records that several recipes share."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from importlib.resources import files
from typing import Any

from ...catalogue.lookup import data_root
from ...catalogue.reader import load_document
from ...errors import ExactnessError, GlmrefError, UsageError
from ...exact import Exact
from ...exact.expression import parse
from ...findings import Proof
from ...prove.verifier import verify
from ..search import Found

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
#: Largest residual in double precision of an end that is taken for a solution.
SOLVED = 1e-10

#: An orbit is lost when the relative error of its energy passes this.
LOST = 0.1

#: A note that `campaigns/test_long_survey.py` compares with the data it names.
GROWS_IN_SURVEY = (
    "Over ten million steps from its default start its energy error grows, at one or more of three "
    "step sizes, on {}, see data/measurements/long-survey.json."
)


@cache
def _measured(name: str) -> Any:
    path = data_root() / "measurements" / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8"))


def survey_notes(name: str) -> list[str]:
    """Return the note on ten million steps of eight problems for a method file, or nothing."""
    said = []
    for row in _measured("long-survey")["rows"]:
        ends = {run["verdict"] for run in row["runs"] if not run["renew"]}
        if (row["method"], row["steps"]) == (name, 10_000_000) and ends & {"grows", "lost"}:
            said.append(row["problem"] + " (lost)" * ("lost" in ends))
    return [GROWS_IN_SURVEY.format("; ".join(said))] if said else []


def kepler_notes(name: str) -> list[str]:
    """Return the notes on long runs of Kepler's problem for a method file.

    There is one where ten million steps of some run are not bounded, and one where a hundred
    million are not.
    """
    kinds = ((GROWS_ON_KEPLER, "runs"), (GROWS_LATER_ON_KEPLER, "further"))
    where = ((text, grown(_measured("kepler-long")[key])) for text, key in kinds)
    return [text.format(found[name]) for text, found in where if name in found]


def grown(runs: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return the eccentricities at which runs of a method are not bounded, as a text, by method."""
    grows: dict[str, list[str]] = {}
    lost: dict[str, list[str]] = {}
    for run in runs:
        if not run["bounded"]:
            last = run["energy"][-1]
            grows.setdefault(run["method"], []).append(run["eccentricity"])
            if run["outcome"] != "completed" or last is None or last > LOST:
                lost.setdefault(run["method"], []).append(run["eccentricity"])
    return {
        name: in_words(where)
        + (f" (the orbit is lost at {in_words(lost[name])})" if name in lost else "")
        for name, where in grows.items()
    }


def in_words(texts: Sequence[str]) -> str:
    """Join texts as in a sentence: "a, b and c"."""
    return " and ".join([", ".join(texts[:-1]), texts[-1]] if texts[1:] else texts)


#: Called with (what is done, steps done, steps in all).
Progress = Callable[[str, int, int], None]


@cache
def stored(name: str) -> Any:
    """Return a table of numbers beside the recipes: a JSON file of this folder."""
    return json.loads(files("glmref.derive.recipes").joinpath(name).read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Statement:
    """One thing that was found, and how it was proved."""

    text: str
    proof: Proof


@dataclass(frozen=True)
class Derivation:
    """What a recipe found."""

    recipe: str  #: Its name.
    documents: Sequence[Mapping[str, Any]]  #: Method documents, complete and proved.
    statements: Sequence[Statement]  #: What was proved on the way.
    refused: bool = False  #: Whether the requested method does not exist.


#: Makes a document with what was proved of it.
Make = Callable[[], tuple[dict[str, Any], Sequence[Statement]]]


def in_turn(recipe: str, makers: Mapping[str, Make], progress: Progress) -> Derivation:
    """Return the derivation of several methods, one after another, by their names."""
    documents, statements = [], list[Statement]()
    for k, (name, make) in enumerate(makers.items()):
        progress(name, k, len(makers))
        document, proved = make()
        documents.append(document)
        statements += proved
    progress("done", len(makers), len(makers))
    return Derivation(recipe, documents, statements)


def searched(
    recipe: str,
    ends: Iterable[Found],
    make: Callable[[Found], tuple[dict[str, Any] | None, Sequence[Statement]]],
    *,
    wanted: int,
    methods: str = "methods",
) -> Derivation:
    """Return the derivation of the first methods that are wanted of a search.

    ``make`` completes an end that is a solution, to ``None`` where it is not of the kind requested;
    ``methods`` is what they are called.
    """
    documents, statements = [], list[Statement]()
    best, count = float("inf"), 0
    for found in ends:
        best, count = min(best, found.residual), count + 1
        if found.residual > SOLVED or len(documents) >= wanted:
            continue
        try:
            document, proved = make(found)
        except GlmrefError as error:
            document, proved = None, [Statement(f"start {found.number}: {error}", Proof.MEASURED)]
        documents += [document] if document else []
        statements += proved
    text = f"{count} starts, smallest residual {best:.3g}, {len(documents)} {methods} completed"
    return Derivation(recipe, documents, [*statements, Statement(text, Proof.MEASURED)])


_THESIS = (
    "Khan, M. S., G-symplectic partitioned general linear methods for Hamiltonian systems, "
    "MS thesis, COMSATS University Islamabad, Lahore Campus, 2018"
)
_THESIS_BIBTEX = (
    "@mastersthesis{khan2018,\n  author = {Khan, M. S.},\n  title = {{G-symplectic partitioned "
    "general linear methods for Hamiltonian systems}},\n  school = {COMSATS University Islamabad, "
    "Lahore Campus},\n  year = {2018},\n}"
)


def proved_exactly(document: Mapping[str, Any]) -> Statement:
    """Verify all claims of a method document exactly.

    Raises
    ------
    ExactnessError
        Naming the claims that fail, which would be an error of the recipe.
    """
    findings = verify(load_document(document, where=document["name"]))
    failing = [x.claim for x in findings if str(x.verdict) != "holds"]
    if failing or any(x.proof is not Proof.EXACT for x in findings):
        raise ExactnessError(f"{document['name']}: not proved exactly: {', '.join(failing)}")
    return Statement(f"{document['name']}: {', '.join(x.claim for x in findings)}", Proof.EXACT)


def complete_exactly(
    document: dict[str, Any], claims: Mapping[str, Any], source: Mapping[str, Any],
    notes: Sequence[str],
) -> None:  # fmt: skip
    """Add claims, of which each is proved exactly, source and notes to a document.

    Raises
    ------
    ExactnessError
        Naming the claims that are not.
    """
    document |= {"claims": dict(claims), "source": dict(source)}
    if notes:
        document["notes"] = list(notes)
    proved_exactly(document)


def rational_option(name: str, text: str) -> Fraction:
    """Read an option that is a rational number.

    Raises
    ------
    UsageError
        For any other text.
    """
    value = parse(text)
    fraction = value.as_fraction() if isinstance(value, Exact) else None
    if fraction is None:
        raise UsageError(f"`{name}` must be rational, such as 1/3, got {text!r}")
    return fraction


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
    """Return the source record of the thesis."""
    record: dict[str, Any] = {"citation": _THESIS, "where": where, "status": status}
    if errata:
        record["errata"] = list(errata)
    if notes:
        record["notes"] = notes
    return {**record, "bibtex": _THESIS_BIBTEX}


_CONDITIONS = (
    "Butcher, J. C. and Imran, G., Order conditions for G-symplectic methods, BIT Numerical "
    "Mathematics 55 (2015), 927-948"
)


def derived_source(where: str, recipe: str = "", conditions: str = _CONDITIONS) -> dict[str, Any]:
    """Return the source record of a method that was found by a recipe of this package.

    ``conditions`` says where those stand from which it was derived.
    """
    command = f"glmref derive {recipe}".rstrip()
    return {
        "citation": f"glmref, derived by `{command}` from the conditions of {conditions}",
        "where": where,
        "status": "derived",
    }
