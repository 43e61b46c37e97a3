"""What a scene will do, before anything is done: tasks, modules, what is recorded, the cost."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from .. import __version__
from ..catalogue.lookup import document, load
from ..compute.records import key_of
from ..engine.clocks import solved_form
from ..engine.kept import expressed
from ..engine.kernel import choose_form
from ..engine.shape import shape_of
from ..errors import GlmrefError
from ..measure.peers import package_of
from ..measure.prediction import Prediction, predict
from ..method import Method
from ..problems.model import Problem
from .model import ASK, TIMED, Scene

#: Evaluations of one stage of an equation that has to be solved, about: predictor and rounds.
ROUNDS = 6
#: Packages that every scene needs: exact coefficients and arrays; then kernels.
ALWAYS = ("flint", "numpy")
KERNELS = "llvmlite"
#: What only the error of the state needs, where the solution is known in closed form.
CLOSED_FORMS = "mpmath"
#: Questions that are answered from samples of one long run.
SAMPLED = frozenset({"invariants", "law", "parasitic"})
#: What a record holds, whatever is asked.
RECORDED = ("outcome", "steps", "seconds with quartiles", "evaluations", "iterations", "start")


@dataclass(frozen=True)
class Plan:
    """What running a scene means."""

    scene: Scene
    #: What is measured, one JSON-ready mapping each, in order; its hash is its key.
    tasks: tuple[Mapping[str, Any], ...]
    modules: tuple[str, ...]  #: Packages besides the standard library that are imported.
    recorded: tuple[str, ...]  #: What each record holds.
    evaluations: int  #: Right-hand-side evaluations in all: exactly, where no stage is implicit.
    absent: tuple[str, ...]  #: Packages of peers that are not installed; their tasks are left out.
    reference: str = ""  #: Where the right last state comes from, ``""`` where it is not asked for.

    def as_json(self) -> dict[str, Any]:
        """Return the plan in JSON's types."""
        return {
            "format": "glmref-plan-1",
            "scene": self.scene.name,
            "question": self.scene.question,
            "modules": list(self.modules),
            "recorded": list(self.recorded),
            "evaluations": self.evaluations,
            "reference": self.reference,
            "absent": list(self.absent),
            "tasks": [dict(task) for task in self.tasks],
        }


def plan(scene: Scene) -> Plan:
    """Plan a scene: list the runs, what they load, and about what they cost.

    Raises
    ------
    DataError
        For a method file that cannot be read.
    """
    subject = scene.subject
    tasks: list[Mapping[str, Any]] = []
    evaluations = 0
    for name in scene.methods:
        each = _evaluations(load(name), subject)
        doc = document(name)
        fingerprint = key_of({"document": doc})
        for h, steps in scene.grid:
            tasks.append(task_of(scene, name, doc["name"], fingerprint, h, steps))
            evaluations += steps * each * (_runs(scene) + ("orbit" in scene.ask))
    modules: list[str] = list(ALWAYS)
    absent: list[str] = []
    if "state" in scene.ask and subject.exact is not None:
        modules.append(CLOSED_FORMS)
    modules.append(KERNELS)
    if shape_of(expressed(subject)).opaque:
        modules.append("numba")  # a right-hand side in Python is compiled by numba alone
    if scene.peers:
        for peer in scene.peers:
            package = package_of(peer)
            if find_spec(package) is None:
                absent.append(package)
                continue
            modules.append(package)
            tasks += [_peer_task(scene, peer, tolerance) for tolerance in scene.tolerances]
    recorded = (*RECORDED, *(ASK[question] for question in scene.ask if question != "picture"))
    return Plan(
        scene,
        tuple(tasks),
        tuple(dict.fromkeys(modules)),
        recorded,
        evaluations,
        tuple(dict.fromkeys(absent)),
        _reference(scene, subject),
    )


def predictions(scene: Scene) -> tuple[Prediction, ...]:
    """Predict when the runs of a scene that asks ``parasitic`` are lost, from their first steps."""
    if "parasitic" not in scene.ask or scene.renew:
        return ()
    found = []
    for name in scene.methods:
        for h, _ in scene.grid:
            with suppress(GlmrefError):  # its task will say why it cannot be run
                found.append(predict(load(name), scene.subject, h, scene.t_end, start=scene.start))
    return tuple(found)


def _reference(scene: Scene, subject: Problem) -> str:
    """Say where the right last state comes from."""
    if "state" not in scene.ask:
        return ""
    if subject.exact is not None:
        return "closed form"
    ends = {float(subject.t_span[0]) + n * h for h, n in scene.grid}
    known = [float(one.t) for one in subject.references]
    if all(any(abs(t - end) <= 1e-12 * max(1.0, abs(end)) for t in known) for end in ends):
        return "stored"
    return "computed: gauss-5, halving h until two runs agree, for each end time"


def _asked(scene: Scene) -> list[str]:
    """Return questions that change what is measured, sorted: a picture is drawn from records."""
    return sorted(question for question in scene.ask if question != "picture")


def _common(scene: Scene) -> dict[str, Any]:
    return {
        "version": __version__,
        "problem": scene.problem,
        "parameters": {k: str(v) for k, v in scene.parameters.items()},
        **({} if scene.definition is None else {"definition": dict(scene.definition)}),
        "t_end": scene.t_end,
        "ask": _asked(scene),
        "repeats": _runs(scene),
        "budget": scene.budget,
    }


def task_of(
    scene: Scene, name: str, method: str, fingerprint: str, h: float, steps: int
) -> dict[str, Any]:
    """Return the task of one run of a scene; its hash is its key."""
    return {
        **_common(scene),
        "kind": "method",
        "method": method,
        "file": name if name.endswith(".json") else None,
        "fingerprint": fingerprint,
        "h": h,
        "steps": steps,
        "start": scene.start,
        **({"renew": scene.renew} if scene.renew else {}),
    }


def _peer_task(scene: Scene, peer: str, tolerance: float) -> dict[str, Any]:
    ask = [question for question in _asked(scene) if question not in ("orbit", "limit")]
    return {**_common(scene), "ask": ask, "kind": "peer", "peer": peer, "tolerance": tolerance}


def _runs(scene: Scene) -> int:
    """Return how often a task is run: ``repeats`` times where time is asked, else once."""
    return scene.repeats if scene.answer.kind in TIMED else 1


def _evaluations(method: Method, subject: Problem) -> int:
    """Return the evaluations of a step: exactly, where no stage is implicit."""
    try:
        form, _ = choose_form(method, solved_form(subject, method), "auto")
    except GlmrefError:  # the method does not apply: its tasks will say so, and cost nothing
        return 0
    return form.forces + ROUNDS * sum(form.solved)
