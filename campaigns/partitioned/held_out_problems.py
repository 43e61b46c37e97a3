"""Forty separable problems on which no method of this project was trained.

Hamiltonians as text, with initial values, in the JSON file of this name: orbits and galaxies,
wells, molecules, chains, lattices and bodies up to 64, thirty-one with T = p^T p / 2 or with masses
and nine with another T. They were chosen before any of them was run. Kepler's problem is there with
other eccentricities than those of training, Hénon-Heiles with other energies, and a Toda chain that
is closed to a ring.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.problems.table import from_table


@dataclass(frozen=True)
class Held:
    """A problem and how far it is solved."""

    #: The short and the long horizon.
    t_end: float
    longer: float
    least: int  #: Evaluations at which the grid of the short horizon begins.
    #: As in a problem of a user's own; without H, the parameters of Kepler's problem.
    H: str = ""
    y0: Any = None
    parameters: Mapping[str, Any] | None = None
    quadratic: bool = True  #: Whether T is quadratic.
    most: int = 1_000_000  #: No run takes more evaluations.
    about: str = ""  #: What it is, where the name does not say it.


_FILE = Path(__file__).with_suffix(".json")
PROBLEMS: Mapping[str, Held] = {
    name: Held(**entry) for name, entry in json.loads(_FILE.read_text(encoding="utf-8")).items()
}


@cache
def problem_of(name: str) -> Problem:
    """Build one of the problems."""
    held = PROBLEMS[name]
    if not held.H:
        return problem("kepler", **held.parameters or {})
    table = {"H": held.H, "y0": held.y0, "t_end": held.t_end, "name": name}
    return from_table(table | ({"parameters": held.parameters} if held.parameters else {}))
