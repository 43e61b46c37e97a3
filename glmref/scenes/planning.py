"""What a scene will do, before anything is done: tasks, modules, what is recorded, the cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from .. import __version__
from ..catalogue import document, load
from ..experiments.records import key_of
from ..method import GLM, PartitionedGLM
from .model import ASK, Scene

__all__ = ["Plan", "plan"]

#: Evaluations of one stage of an equation that has to be solved, about: predictor and rounds.
ROUNDS = 6
#: Packages that every scene needs: exact coefficients, arrays, starts and closed forms, kernels.
ALWAYS = ("flint", "numpy", "mpmath", "llvmlite")
#: What a record holds, whatever is asked.
RECORDED = ("outcome", "steps", "seconds with quartiles", "evaluations", "iterations", "start")


@dataclass(frozen=True)
class Plan:
    """What running a scene means.

    Attributes
    ----------
        scene: the scene.
        tasks: what is measured, one JSON-ready mapping each, in order; its hash is its key.
        modules: packages besides the standard library that are imported.
        recorded: what each record holds.
        evaluations: right-hand-side evaluations in all, about.
        absent: packages of peers that are not installed; their tasks are left out.
    """

    scene: Scene
    tasks: tuple[Mapping[str, Any], ...]
    modules: tuple[str, ...]
    recorded: tuple[str, ...]
    evaluations: int
    absent: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the plan in JSON's types."""
        return {
            "format": "glmref-plan-1",
            "scene": self.scene.name,
            "question": self.scene.question,
            "modules": list(self.modules),
            "recorded": list(self.recorded),
            "evaluations": self.evaluations,
            "absent": list(self.absent),
            "tasks": [dict(task) for task in self.tasks],
        }


def plan(scene: Scene) -> Plan:
    """Plan a scene: list the runs, what they load, and about what they cost.

    Raises
    ------
        DataError: for a method file that cannot be read.
    """
    from ..engine.shape import shape_of
    from ..problems import problem

    tasks: list[Mapping[str, Any]] = []
    evaluations = 0
    for name in scene.methods:
        method = load(name)
        fingerprint = key_of({"document": document(name)})
        for h, steps in scene.grid:
            tasks.append(_task(scene, name, fingerprint, h, steps))
            evaluations += steps * _per_step(method) * _runs(scene)
    modules: list[str] = list(ALWAYS)
    absent: list[str] = []
    if shape_of(problem(scene.problem, **scene.parameters)).opaque:
        modules.append("numba")  # a right-hand side in Python is compiled by numba alone
    if scene.peers:
        from ..experiments.peers import package_of

        for peer in scene.peers:
            package = package_of(peer)
            if find_spec(package) is None:
                absent.append(package)
                continue
            modules.append(package)
            tasks += [_peer_task(scene, peer, tolerance) for tolerance in scene.tolerances]
    if "picture" in scene.ask and find_spec("matplotlib") is not None:
        modules.append("matplotlib")
    recorded = (*RECORDED, *(ASK[question] for question in scene.ask if question != "picture"))
    return Plan(
        scene,
        tuple(tasks),
        tuple(dict.fromkeys(modules)),
        recorded,
        evaluations,
        tuple(dict.fromkeys(absent)),
    )


def _asked(scene: Scene) -> list[str]:
    """Questions that change what is measured, sorted: a picture is drawn from records."""
    return sorted(question for question in scene.ask if question != "picture")


def _common(scene: Scene) -> dict[str, Any]:
    return {
        "version": __version__,
        "problem": scene.problem,
        "parameters": {k: str(v) for k, v in scene.parameters.items()},
        "t_end": scene.t_end,
        "ask": _asked(scene),
        "repeats": scene.repeats,
        "budget": scene.budget,
    }


def _task(scene: Scene, name: str, fingerprint: str, h: float, steps: int) -> dict[str, Any]:
    return {
        **_common(scene),
        "kind": "method",
        "method": document(name)["name"],
        "file": name if name.endswith(".json") else None,
        "fingerprint": fingerprint,
        "h": h,
        "steps": steps,
        "start": scene.start,
    }


def _peer_task(scene: Scene, peer: str, tolerance: float) -> dict[str, Any]:
    return {**_common(scene), "kind": "peer", "peer": peer, "tolerance": tolerance}


def _runs(scene: Scene) -> int:
    """How often a task is run: long runs once, timed ones ``repeats`` times."""
    return 1 if {"invariants", "parasitic"} & set(scene.ask) else scene.repeats


def _per_step(method: GLM | PartitionedGLM) -> int:
    """Right-hand-side evaluations of a step, about: one for an explicit stage."""
    if isinstance(method, PartitionedGLM):
        from ..engine.reference import pair_blocks

        blocks = pair_blocks(method)
        # of a separable problem the evaluations of p' = k(q) count, at the stages Q
        inside = [[i for i in block.stages if i < method.n_Q] for block in blocks]
        return sum(
            len(found) * (ROUNDS if block.implicit else 1)
            for block, found in zip(blocks, inside, strict=True)
        )
    from ..engine.tableau import stage_blocks

    return sum(
        len(block.stages) * (ROUNDS if block.implicit else 1) for block in stage_blocks(method.A)
    )
