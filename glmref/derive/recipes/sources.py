"""What files of several recipes say: source records, and notes on what was measured."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from ...catalogue.lookup import data_root

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


def long_notes(name: str) -> list[str]:
    """Return all notes on long runs for a method file."""
    return kepler_notes(name) + survey_notes(name)


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


@cache
def stored(name: str) -> Any:
    """Return a table of numbers beside the recipes: a JSON file of this folder."""
    return json.loads(files("glmref.derive.recipes").joinpath(name).read_text(encoding="utf-8"))


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
