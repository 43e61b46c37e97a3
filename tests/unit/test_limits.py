"""The step size up to which a tableau predicts stability, and where runs do fail."""

import math

import pytest

from glmref import Problem, load, solve
from glmref.measure.limits import ray_end, stable_step
from glmref.scenes import answer, charts, load_scene, plan, run
from glmref.views.chart import Series, svg
from tests.build import scene_text

#: y' = -50 (y - cos t) has the eigenvalue -50.
DECAY = Problem(f=("-50*(y[0] - cos(t))",), y0=(1,), t_span=(0, 2))


@pytest.mark.parametrize(
    ("method", "end"),
    [
        # zeros of |R(-x)| = 1: 2, and of 1 - x + x^2/2 - x^3/6 + x^4/24 = 1
        ("euler", 2.0),
        ("heun-2", 2.0),
        ("rk4", 2.7852935634),
        ("bdf-2", math.inf),
        ("radau-iia-3", math.inf),
        ("gauss-2", math.inf),
    ],
)
def test_ends_on_the_negative_axis_are_those_of_the_literature(method, end):
    assert ray_end(load(method), -1 + 0j) == pytest.approx(end, rel=1e-6)
    assert stable_step(DECAY, load(method), t_end=2) == pytest.approx(end / 50, rel=1e-6)


@pytest.mark.parametrize("method", ["euler", "rk4", "dormand-prince-5"])
def test_runs_stay_below_the_prediction_and_grow_beyond_it(method):
    """The eigenvalue is constant, so that the prediction is sharp: a tenth on both sides shows."""
    limit = stable_step(DECAY, load(method), t_end=2)
    for factor, stays in ((0.9, True), (1.1, False)):
        far = solve(DECAY, method, h=limit * factor, steps=400)
        size = abs(far.y[-1, 0]) if len(far.y) else math.inf
        assert (size < 2) == stays


SCENE = scene_text(
    "decay", 'f = ["-50*y[0]**3 - 50*y[0] + 100*cos(t)"]\ny0 = [1]\nt_end = 20',
    'kind = "accurate"\nat = 1e-4', title="A decay",
    question="Which methods are right to 1e-4, and where do others fail?",
    methods=["radau-iia-3", "euler"], steps=[8, 20, 2000], t_end=20, ask=["state", "limit", "picture"],
)  # fmt: skip


@pytest.fixture(scope="module")
def decay(tmp_path_factory):
    path = tmp_path_factory.mktemp("decay") / "decay.toml"
    path.write_text(SCENE)
    scene = load_scene(path)
    return scene, run(scene)


@pytest.mark.slow
def test_records_and_answers_say_where_methods_fail(decay):
    scene, records = decay
    limits = {(r["method"], r.get("limit")) for r in records}
    assert ("radau-iia-3", "none") in limits
    (limit,) = {r["limit"] for r in records if r["method"] == "euler"}
    assert 0.01 <= limit <= 0.04  # 2 by 50 + 150 y^2 with y between 0 and 1
    outcomes = [r["outcome"] for r in records if r["method"] == "euler"]
    assert outcomes == ["not finite", "not finite", "completed"]
    said = answer(scene, records)
    assert f"euler (h = 1, predicted from {limit:.2g})" in said and "radau-iia-3 (" in said
    assert "limit" in plan(scene).tasks[0]["ask"]


def test_pictures_have_failures_and_limits(decay):
    scene, records = decay
    names = [chart.suffix for chart in charts(scene, records)]
    assert names == ["", "-evaluations", "-h"]
    by_h = charts(scene, records)[-1]
    euler = next(one for one in by_h.series if one.name == "euler")
    assert [x for x, _ in euler.failures] == [2.5, 1] and len(euler.points) == 1
    assert "not finite" in euler.failures[0][1] and euler.limit == pytest.approx(0.02, rel=1)
    work = next(one for one in charts(scene, records)[1].series if one.name == "euler")
    # evaluations of failed runs are those of all their steps: one a step
    assert [x for x, _ in work.failures] == [8, 20] and work.limit == pytest.approx(
        20 / euler.limit
    )
    text = svg(by_h.series, title="t", x_label="h", y_label="error")
    assert "stability is predicted up to" in text and "euler: h = 2.5, not finite" in text


def test_a_method_that_always_fails_is_drawn():
    lost = Series("lost", (), (), ((0.1, "h = 0.1, not finite"),), 0.01)
    text = svg((Series("good", ((0.1, 1e-3),)), lost), title="t", x_label="h", y_label="e")
    assert text.count("not finite") == 1 and ">lost</text>" in text and "not drawn" not in text
    assert svg((lost,), title="t", x_label="h", y_label="e").count("not finite") == 1


def test_an_order_is_not_read_from_errors_beyond_the_state():
    scene = load_scene("prothero-robinson", quick=True)
    grid = [(scene.t_end / n, n) for n in (2, 4, 8)]
    records = [
        {"task": {"kind": "method", "method": name, "h": h}, "h": h, "outcome": how,
         "state_error": error}
        for name, errors in (("rk4", (1e40, 1e90, None)), ("gauss-2", (1e-2, 2.5e-3, 6.25e-4)))
        for (h, _), error in zip(grid, errors, strict=True)
        for how in ["completed" if error else "not finite"]
    ]  # fmt: skip
    assert answer(scene, records) == "order seen: gauss-2 2.0; rk4: not finite"
