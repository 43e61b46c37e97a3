"""Scenes: a problem, methods, step sizes and questions as data; nothing that is not asked runs.

Public names::

    load_scene(name or path, quick=False) -> Scene      names() -> list of shipped scenes
    plan(scene) -> Plan                                 tasks, modules, cost, before anything runs
    run(scene, records=..., advance=...) -> list        measure what is missing, in order
    answer(scene, records) -> str                       the scene's answer, in one line
    rows, charts, orbits                                what to show of records
"""

from __future__ import annotations

from .answers import answer
from .model import ASK, Answer, Scene
from .planning import Plan, plan
from .reading import load_scene, names
from .running import SYSTEM_REFUSED, mixed_machines, run
from .views import charts, orbits, rows

__all__ = [
    "ASK",
    "SYSTEM_REFUSED",
    "Answer",
    "Plan",
    "Scene",
    "answer",
    "charts",
    "load_scene",
    "mixed_machines",
    "names",
    "orbits",
    "plan",
    "rows",
    "run",
]
