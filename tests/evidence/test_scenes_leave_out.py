"""What a scene does not ask is neither imported nor evaluated: plans kept to the letter.

The scenes run in a process of their own, cut to a few steps of every fifth method: what a step
loads and evaluates does not hang on how many there are.
"""

import dataclasses
import itertools
import json
import os
import subprocess
import sys

import pytest

from glmref.scenes import load_scene, names, plan

#: Outside packages that count; what these import in turn (numba's llvmlite) is theirs.
WATCHED = ("flint", "llvmlite", "matplotlib", "mpmath", "numba", "numpy", "scipy", "click", "tqdm")
STEPS = 40

SCRIPT = """
import dataclasses, json, sys
from glmref.catalogue.lookup import load
from glmref.engine.clocks import solved_form
from glmref.engine.kernel import choose_form
from glmref.scenes import load_scene, plan, run

def short(scene, steps):
    h = scene.grid[0][0]
    ask = tuple(q for q in scene.ask if q != "picture")
    return dataclasses.replace(
        scene, h=(h,), steps=(), t_end=steps * h, ask=ask, peers=(), repeats=1, budget=60.0,
        methods=scene.methods[::5])

told = []
for name in json.loads(sys.argv[1]):
    scene = short(load_scene(name), int(sys.argv[3]))
    todo = plan(scene)
    before = {m.partition(".")[0] for m in sys.modules} & set(json.loads(sys.argv[2]))
    records = run(todo)
    after = {m.partition(".")[0] for m in sys.modules} & set(json.loads(sys.argv[2]))
    rows = []
    for record in records:
        planned, method = None, record["task"]["method"]
        if record["outcome"] == "completed":
            chosen = load(record["task"]["file"] or method)
            form, _ = choose_form(chosen, solved_form(todo.scene.subject, chosen), "auto")
            if len(set(form.solved)) < 2:
                planned = form.evaluations(record["steps"], record["iterations"])
        rows.append([method, record["outcome"], planned,
                     record.get("evaluations"), record.get("message", "")])
    told.append({"name": name, "plan": list(todo.modules), "before": sorted(before),
                 "after": sorted(after), "rows": rows})
print(json.dumps(told))
"""


def short(scene, **changes):
    """The scene without peers and pictures."""
    ask = tuple(question for question in scene.ask if question != "picture")
    return dataclasses.replace(scene, ask=ask, peers=(), **changes)


def carried_out(listed):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", SCRIPT, json.dumps(listed), json.dumps(WATCHED),
         str(STEPS)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def check(told):
    """Modules are those of the plans so far, evaluations those of the plan, outcomes have names."""
    union = set()
    for scene in told:
        completed = any(outcome == "completed" for _, outcome, *_ in scene["rows"])
        # a closed form is for the error of a run that ends well
        union |= set(scene["plan"]) - (set() if completed else {"mpmath"})
        assert set(scene["after"]) == union, scene["name"]
        for method, outcome, planned, evaluations, message in scene["rows"]:
            assert outcome != "internal error", (scene["name"], method, message)
            if outcome == "completed" and planned is not None:
                assert evaluations == planned, (scene["name"], method)


def modules_of(name):
    return plan(short(load_scene(name))).modules


@pytest.mark.slow
def test_every_scene_loads_and_evaluates_exactly_what_its_plan_says():
    # fewest modules first: what a scene adds is seen, because nothing loaded it before
    ordered = sorted(names(), key=lambda name: (len(modules_of(name)), name))
    assert "mpmath" not in modules_of("rigid-body") and "mpmath" in modules_of("kepler")
    told = carried_out(ordered if "GLMREF_LONG" in os.environ else ordered[::2])
    check(told)
    assert len(told) >= 15
    counted = sum(row[2] is not None for scene in told for row in scene["rows"])
    assert counted >= 15


@pytest.mark.slow
def test_a_plan_that_promises_too_little_is_noticed():
    (told,) = carried_out(["rigid-body"])
    with pytest.raises(AssertionError, match="rigid-body"):
        check([{**told, "plan": [x for x in told["plan"] if x != "llvmlite"]}])
    told["rows"][0][2] += 1
    with pytest.raises(AssertionError, match="rk4"):
        check([told])


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", names())
def test_one_question_less_never_costs_more(name):
    scene = load_scene(name)
    whole = plan(scene)
    for less in itertools.combinations(scene.ask, len(scene.ask) - 1):
        if set(less) <= {"picture"}:
            continue
        fewer = plan(dataclasses.replace(scene, ask=less))
        assert fewer.evaluations <= whole.evaluations
        assert set(fewer.modules) <= set(whole.modules)
        assert set(fewer.recorded) < set(whole.recorded) or "picture" not in less
        assert [task["repeats"] for task in fewer.tasks] == [t["repeats"] for t in whole.tasks]


@pytest.mark.slow
def test_one_question_less_takes_no_more_evaluations_and_gives_no_more_numbers():
    from glmref.scenes import run

    scene = short(load_scene("rigid-body"), t_end=20.0)
    asked = dataclasses.replace(scene, ask=("invariants", "law"))
    rows = run(asked)
    fewer = run(dataclasses.replace(scene, ask=("invariants",)))
    assert [r["evaluations"] for r in fewer] == [r["evaluations"] for r in rows]
    assert "law" in rows[0] and "law" not in fewer[0]


def test_evaluations_counted_are_evaluations_made():
    """The counter of a run against a right-hand side that counts its calls."""
    from glmref.catalogue.lookup import load
    from glmref.engine.solve import solve
    from glmref.problems import Problem

    for name in ("rk4", "heun-3", "gauss-2", "sdirk-3", "dimsim-2-type-1"):
        calls = 0

        def f(t, y):
            nonlocal calls
            calls += 1
            return -0.5 * y

        found = solve(
            Problem(f=f, y0=[1.0]), load(name), h=0.1, steps=10, engine="interpreted",
            solver="fixed-point",
        )  # fmt: skip
        # beside the run itself f is called five times to look at it, and once for the slope at the
        # start that a kernel of explicit stages remembers
        assert found.total_evaluations <= calls <= found.total_evaluations + 6, name
