"""Scenes: read strictly with line numbers, planned before they run, answered from their records."""

import json
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.catalogue.lookup import data_root, load, path_of
from glmref.cli import main
from glmref.compute.records import Records
from glmref.errors import DataError, GlmrefError, UsageError
from glmref.scenes import answer, charts, load_scene, names, orbits, plan, rows, run
from glmref.scenes.answers import seconds_at
from glmref.scenes.reading import MAX_NAME, MAX_TEXT, MOST_ENTRIES, MOST_STEPS
from tests.build import refused, scene_text

SMALL = scene_text(
    "small", 'name = "harmonic-oscillator"\nfrequency = "1"',
    'kind = "fastest"\nat = 1e-2\n\n[quick]\nsteps = [10]', methods=["rk4", "heun-2"],
    steps=[20, 40], t_end="2*pi", ask=["state", "energy", "picture"], repeats=1,
)  # fmt: skip


def write(folder, text=SMALL, name="small.toml"):
    path = Path(folder) / name
    path.write_text(text, encoding="utf-8")
    return path


#: Parts of that text which tests replace.
OSCILLATOR, GRID = '"harmonic-oscillator"\nfrequency = "1"', "steps = [20, 40]"
BOTH, ASKED = '["rk4", "heun-2"]', '"state", "energy"'
FASTEST = 'kind = "fastest"\nat = 1e-2'
PEER = ("repeats = 1", 'peers = ["scipy-rk45"]\ntolerances = [1e-6]')


def loaded(folder, *changes, text=SMALL):
    """Load the scene in which each first of two texts is replaced by the second."""
    for old, new in zip(changes[::2], changes[1::2], strict=True):
        assert old in text, old
        text = text.replace(old, new)
    return load_scene(write(folder, text))


def test_step_sizes_may_be_a_range(tmp_path):
    steps = loaded(tmp_path, GRID, "steps = { from = 10, to = 10_000, count = 4 }").steps
    assert steps == (10, 100, 1000, 10000)
    h = loaded(tmp_path, GRID, 'h = { from = "1/10", to = 0.001, count = 3 }').grid
    # each h is 2 pi by a whole number, so that runs end at the same time
    assert [n for _, n in h] == [63, 628, 6283]
    assert all(size == pytest.approx(2 * 3.141592653589793 / n, rel=1e-15) for size, n in h)
    linear = "steps = { from = 2, to = 5, count = 4, spacing = 'linear' }"
    assert loaded(tmp_path, GRID, linear).steps == (2, 3, 4, 5)


def line_of(text, start):
    return next(k for k, line in enumerate(text.splitlines(), 1) if line.startswith(start))


# --- reading --------------------------------------------------------------------------------------


def test_a_scene_may_renew_the_values(tmp_path):
    text = SMALL.replace('methods = ["rk4", "heun-2"]', 'methods = ["g4123", "rk4"]')
    never = load_scene(write(tmp_path, text))
    renewed = load_scene(write(tmp_path, "renew = 15\n" + text, "renewed.toml"))
    assert (never.renew, renewed.renew) == (0, 15)
    assert all("renew" not in task for task in plan(never).tasks)
    found = {(x["method"], x["steps"]): x["start_evaluations"] for x in run(renewed)}
    once = {(x["method"], x["steps"]): x["start_evaluations"] for x in run(never)}
    assert found["rk4", 40] == once["rk4", 40] == 0
    assert found["g4123", 20] > once["g4123", 20]  # at step 15
    assert found["g4123", 40] > found["g4123", 20]  # at steps 15 and 30
    with pytest.raises(DataError, match="line 1: `renew` must be a whole number from 1"):
        load_scene(write(tmp_path, "renew = 0\n" + text))


@pytest.mark.parametrize("name", names())
def test_every_shipped_scene_keeps_the_schema(name):
    jsonschema = pytest.importorskip("jsonschema")
    folder = data_root()
    schema = json.loads((folder / "schema" / "glmref-scene-1.schema.json").read_text("utf-8"))
    document = tomllib.loads((folder / "scenes" / f"{name}.toml").read_text("utf-8"))
    jsonschema.Draft202012Validator(schema).validate(document)


def test_scenes_and_methods_may_name_their_schema_for_editors(tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    folder = data_root()
    for form, place in (
        ("scene-1", folder / "scenes" / "kepler.toml"),
        ("method-1", path_of("rk4")),
    ):
        text = place.read_text("utf-8")
        word = '"$schema" = "x"\n' if form == "scene-1" else '{"$schema": "x",'
        text = word + text if form == "scene-1" else text.replace("{", word, 1)
        (tmp_path / place.name).write_text(text, encoding="utf-8")
        schema = json.loads((folder / "schema" / f"glmref-{form}.schema.json").read_text("utf-8"))
        document = tomllib.loads(text) if form == "scene-1" else json.loads(text)
        jsonschema.Draft202012Validator(schema).validate(document)
        assert document["$schema"] == "x"
    assert load_scene(tmp_path / "kepler.toml").name == "kepler"
    assert load(tmp_path / "rk4.json").name == "rk4"
    refused(DataError, "must be a text", load_scene, write(tmp_path, '"$schema" = 1\n' + SMALL))


@pytest.mark.slow
def test_the_quick_title_is_that_of_table_picture_and_report(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = SMALL.replace("A small scene", "100 periods").replace('"1"', '"2"')
    text = text.replace("[quick]\n", '[quick]\nt_end = "pi"\ntitle = "Ten periods"\n')
    write(tmp_path, text)
    assert load_scene("small.toml", quick=True).title == "Ten periods (quick run)"
    assert main(["run", "small.toml", "--quick", "--output", "out"]) == 0
    assert "Ten periods (quick run)" in capsys.readouterr().out
    drawn = [path.read_text(encoding="utf-8") for path in Path("out").glob("*-quick*.svg")]
    assert drawn and all(
        "Ten periods (quick run)" in one and "100 periods" not in one for one in drawn
    )
    assert load_scene("kepler", quick=True).title.startswith(
        "Kepler problem, eccentricity 0.6, ten"
    )


@pytest.mark.parametrize("key", ["format", "name", "title", "question", "ask"])
def test_a_key_that_is_missing_is_named(tmp_path, key):
    lines = SMALL.splitlines(keepends=True)
    first = next(n for n, x in enumerate(lines) if x.startswith(f"{key} = "))
    path = write(tmp_path, "".join(lines[:first] + lines[first + 1 :]))
    refused(DataError, f"line 1: the key `{key}` is missing$", load_scene, path)


def test_lines_are_found_below_strings_and_lists_of_several_lines(tmp_path):
    text = SMALL.replace(
        'question = "Does it work?"', 'question = """\nh = [1]\n[quick]\nDoes it work?"""'
    ).replace('["rk4", "heun-2"]', '[\n  "rk4", # ]\n  "heun-2",\n]')
    with pytest.raises(DataError, match=f"line {line_of(text, 'repeats')}:"):
        load_scene(write(tmp_path, text.replace("repeats = 1", "repeats = 0")))


def test_unknown_names_and_missing_files_are_usage_errors(tmp_path):
    refused(UsageError, "does not exist", load_scene, str(tmp_path / "none.toml"))
    refused(UsageError, "is a folder", load_scene, str(tmp_path))


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_bytes(b"\xff\xfe\x00")
    refused(DataError, "not UTF-8", load_scene, path)


@settings(deadline=None)
@given(st.text(max_size=300))
def test_any_text_is_a_scene_or_one_sentence(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("scene") / "any.toml"
    path.write_text(text, encoding="utf-8", errors="replace")
    error = refused(GlmrefError, "", load_scene, path)
    assert "any.toml" in error


@pytest.mark.slow
def test_classes_and_properties_name_methods(tmp_path):
    given = f"methods = {BOTH}"
    methods = loaded(tmp_path, given, 'classes = ["composition"]').methods
    assert set(methods) >= {"yoshida-4", "suzuki-4"}
    assert "g6245" in loaded(tmp_path, given, 'classes = ["parasitism-free"]').methods


# --- plans ----------------------------------------------------------------------------------------


def test_the_estimate_for_implicit_methods_is_right_to_a_factor_of_three(tmp_path):
    scene = loaded(tmp_path, BOTH, '["gauss-2", "gsymplectic-n"]')
    spent = sum(record["evaluations"] for record in run(scene))
    assert spent / 3 < plan(scene).evaluations < 3 * spent


def test_methods_that_cannot_be_run_on_a_problem_count_no_evaluations(tmp_path):
    predators = (OSCILLATOR, '"lotka-volterra"')  # no pair steps it
    both = plan(loaded(tmp_path, *predators, BOTH, '["rk4", "stormer-verlet"]', ASKED, '"state"'))
    alone = plan(loaded(tmp_path, *predators, BOTH, '["rk4"]', ASKED, '"state"'))
    assert both.evaluations == alone.evaluations == 4 * sum((20, 40))
    assert len(both.tasks) == 2 * len(alone.tasks)


def test_tasks_differ_by_everything_that_can_change_a_result(tmp_path):
    from glmref.compute.records import key_of

    base = {key_of(task) for task in plan(loaded(tmp_path)).tasks}
    assert len(base) == 4
    for old, new in (('frequency = "1"', 'frequency = "2"'), ("2*pi", "3*pi"), ("[20, 40]", "[21]"),
                     ('"energy", ', ""), ("repeats = 1", 'start = "zero"')):  # fmt: skip
        assert not base & {key_of(t) for t in plan(loaded(tmp_path, old, new)).tasks}, new


def test_a_picture_changes_no_task(tmp_path):
    assert plan(loaded(tmp_path)).tasks == plan(loaded(tmp_path, ', "picture"', "")).tasks


# --- running --------------------------------------------------------------------------------------


def test_a_scene_runs_and_a_second_run_measures_nothing(tmp_path):
    scene = loaded(tmp_path)
    path = tmp_path / "small.sqlite"
    seen = []
    first = run(scene, Records(path), advance=lambda task, record: seen.append(record))
    assert len(first) == len(seen) == 4
    content = path.read_bytes()
    again = run(scene, Records(path), advance=lambda task, record: seen.append(record))
    assert (again, len(seen), path.read_bytes()) == (first, 4, content)


def test_one_more_step_size_measures_only_that(tmp_path):
    path, seen = tmp_path / "small.sqlite", []
    run(loaded(tmp_path), Records(path))
    more = loaded(tmp_path, "[20, 40]", "[20, 40, 80]")
    records = run(more, Records(path), advance=lambda task, record: seen.append(task["steps"]))
    assert (seen, len(records)) == ([80, 80], 6)


def test_an_error_nobody_expected_is_a_record_and_an_interruption_is_obeyed(tmp_path, monkeypatch):
    def raising(error):
        def broken(*args, **options):
            raise error

        monkeypatch.setattr("glmref.scenes.running.measure", broken)

    raising(ZeroDivisionError("by design"))
    records = run(loaded(tmp_path))
    assert {record["outcome"] for record in records} == {"internal error"}
    assert records[0]["message"] == "ZeroDivisionError: by design"
    raising(KeyboardInterrupt)
    with pytest.raises(KeyboardInterrupt):
        run(loaded(tmp_path))


def test_peers_that_are_not_installed_are_left_out_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr("glmref.scenes.planning.find_spec", lambda name: None)
    todo = plan(loaded(tmp_path, *PEER))
    assert todo.absent == ("scipy",)
    assert {task["kind"] for task in todo.tasks} == {"method"}


def test_a_peer_runs_beside_the_methods(tmp_path):
    pytest.importorskip("scipy")
    record = run(loaded(tmp_path, *PEER))[-1]
    assert record["outcome"] == "completed" and record["state_error"] < 1e-4


@pytest.mark.parametrize(
    ("changes", "outcomes", "message"),
    [
        ([OSCILLATOR, '"rigid-body"', '"heun-2"', '"stormer-verlet"', ASKED, '"state"'],
         ["completed"] * 2 + ["not applicable"] * 2, "separable"),
        (["[20, 40]", "[1000000000]", "repeats = 1", "budget = 0.05", BOTH, '["heun-2"]', ASKED,
          '"state"'], ["budget spent"], "raise `budget`"),
        ([BOTH, '["bdf-2"]', "[20, 40]", "[10]", OSCILLATOR, '"robertson"', ASKED, '"state"',
          '"2*pi"', "40"], ["start failed"], "use a smaller h"),
        ([BOTH, '["rk4"]', "[20, 40]", "[10]", OSCILLATOR, '"fault-shape"', ASKED, '"state"'],
         ["right-hand side failed"], "must return shape (2,), got (3,)"),
    ],
    ids=["not separable", "budget", "start", "right-hand side"],
)  # fmt: skip
def test_what_a_run_ends_with_is_a_named_outcome(tmp_path, changes, outcomes, message):
    records = run(loaded(tmp_path, *changes))
    assert [record["outcome"] for record in records] == outcomes
    assert message in records[-1]["message"]
    assert outcomes != ["budget spent"] or 0 < records[0]["steps"] < 10**9


def test_only_an_answer_about_time_repeats_a_run(tmp_path):
    often = ("repeats = 1", "repeats = 5")
    assert {t["repeats"] for t in plan(loaded(tmp_path, *often)).tasks} == {5}
    todo = plan(loaded(tmp_path, *often, FASTEST, 'kind = "order"'))
    assert {t["repeats"] for t in todo.tasks} == {1}
    assert todo.evaluations == (4 + 2) * (20 + 40)


# --- orbits ---------------------------------------------------------------------------------------

ORBIT = SMALL.replace('"state", "energy", "picture"', '"state", "orbit", "picture"')


def test_a_scene_that_does_not_ask_takes_no_points(tmp_path, monkeypatch):
    import glmref.scenes.running as module

    asked = []
    monkeypatch.setattr(module, "orbit", lambda *a, **k: asked.append(k) or 1 / 0)
    records = run(loaded(tmp_path))
    assert not asked and all("orbit" not in record for record in records)
    # and where it is asked, that is what runs
    assert "internal error" in {r["outcome"] for r in run(loaded(tmp_path, text=ORBIT))}
    assert [k["steps"] for k in asked] == [20, 40, 20, 40]


def test_an_orbit_of_a_run_that_fails_is_its_good_part(tmp_path):
    changes = ('"rk4", "heun-2"', '"euler"', "[20, 40]", "[100]", '"2*pi"', "100")
    (record,) = run(loaded(tmp_path, *changes, text=ORBIT))
    assert record["orbit"]["ended"].startswith("lost after t = ")
    assert len(record["orbit"]["paths"][0]) < 10
    # too stiff for an explicit method: the values leave the numbers in the third step
    changes = (OSCILLATOR, '"van-der-pol"', '"2*pi"', '"1/50"', '"state", "orbit"', '"orbit"')
    (record, *_) = run(loaded(tmp_path, *changes, FASTEST, 'kind = "ended"', text=ORBIT))
    assert record["outcome"] == "not finite"
    assert record["orbit"]["ended"].startswith("not finite after t = 0.002")
    assert len(record["orbit"]["paths"][0]) == 3


def test_an_orbit_of_a_sampled_run_is_its_own(tmp_path):
    changes = ('"state", "orbit"', '"invariants", "energy", "orbit"', FASTEST, 'kind = "conserved"')
    records = run(loaded(tmp_path, *changes, text=ORBIT))
    assert all(r["drifts"] and r["series"] for r in records)
    assert [len(r["orbit"]["paths"][0]) for r in records] == [21, 41] * 2


def test_orbits_are_pictures_of_their_own(tmp_path):
    scene = loaded(tmp_path, text=ORBIT)
    records = run(scene)
    picture = orbits(scene, records)
    assert picture is not None and (picture.x_label, picture.y_label) == ("q", "p")
    # one path a method, at the largest step at which it is followed to its end
    assert [(one.name, one.h) for one in picture.clouds] == [
        (name, scene.t_end / 20) for name in ("rk4", "heun-2")
    ]
    records[2]["orbit"]["ended"] = "lost after t = 3"
    again = orbits(scene, records)
    assert again is not None and [one.h for one in again.clouds] == [
        scene.t_end / 20, scene.t_end / 40,
    ]  # fmt: skip
    kept = records[0]["orbit"]["paths"][0]
    assert picture.clouds[0].points == tuple((x, y) for _, x, y in kept)
    assert orbits(scene, [{k: v for k, v in r.items() if k != "orbit"} for r in records]) is None
    alone = load_scene(write(tmp_path, ORBIT.replace('"state", ', "").replace("fastest", "ended")))
    assert charts(alone, records) == []


def test_records_keep_their_schema(tmp_path):
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads((data_root() / "schema" / "glmref-record-1.schema.json").read_text("utf-8"))
    check = jsonschema.Draft202012Validator(schema)
    records = run(loaded(tmp_path, text=ORBIT))
    law = ORBIT.replace('"state"', '"energy", "law"').replace('"fastest"', '"law"')
    records += run(load_scene(write(tmp_path, law)))
    changes = (OSCILLATOR, '"rigid-body"', '"heun-2"', '"stormer-verlet"', ASKED, '"state"')
    records += run(loaded(tmp_path, *changes))
    for record in records:
        check.validate(record)
    long = {**records[0]["orbit"], "paths": [[[0.0, 1.0, 0.0]] * 401]}
    for wrong in ({"orbit": long}, {"orbit": {"axes": ["q"]}}, {"format": "x"}, {"key": "7"}):
        assert not check.is_valid({**records[0], **wrong}), wrong


# --- answers and views ----------------------------------------------------------------------------


def made(method, h, **fields):
    seconds = fields.pop("seconds", 1.0)
    return {
        "task": {"kind": "method", "method": method, "file": None, "h": h},
        "method": method, "h": h, "outcome": "completed",
        "seconds": {"median": seconds, "q25": seconds, "q75": seconds, "repeats": 1},
        **fields,
    }  # fmt: skip


DRIFT = {"quantity": "energy", "kind": "quadratic", "largest": 1e-3}


def test_seconds_are_interpolated_between_errors():
    group = [
        made("rk4", 1, state_error=1e-4, seconds=1.0),
        made("rk4", 2, state_error=1e-8, seconds=4.0),
    ]
    assert seconds_at(group, "state", 1e-6) == pytest.approx(2.0)
    assert seconds_at(group, "state", 1e-8) == pytest.approx(4.0)
    assert seconds_at(group, "state", 1e-3) == pytest.approx(1.0)
    assert seconds_at(group, "state", 1e-9) is None
    assert seconds_at([made("rk4", 1)], "state", 1.0) is None


def scene_with(tmp_path, kind, *more, ask=ASKED, grid="[20, 40]"):
    kind = "\n".join([f'kind = "{kind}"', *more])
    return loaded(tmp_path, FASTEST, kind, ASKED, ask, "[20, 40]", grid)


def lost(method, h, outcome="lost"):
    return {**made(method, h), "outcome": outcome}


#: Name or kind, further lines and step numbers of a scene; records; its answer.
ANSWERS = [
    ("fastest at = 1e-2", "", [
        made("rk4", 1, state_error=1e-3, seconds=2e-3),
        made("heun-2", 1, state_error=1e-3, seconds=5e-3),
        made("euler", 1, state_error=1.0, seconds=1e-3),
    ], "relative error 0.01 in the state: rk4 needs 2 ms, heun-2 2.5 times that; not reached by euler"),
    ("fastest at = 1e-2", "", [made("euler", 1, state_error=1.0, seconds=1e-3)], "no method reached"),
    ("accurate at = 1e-3", "", [
        made("rk4", 1, state_error=1e-3, evaluations=4000),
        made("rk4", 2, state_error=1e-4, evaluations=8000),
        made("heun-2", 1, state_error=1e-4, evaluations=70),
        made("euler", 1, state_error=0.5, evaluations=5), lost("leapfrog", 1, "not finite"),
    ], ("relative error 0.001 in the state (evaluations): heun-2 (70), rk4 (4,000); "
       "not by euler (5.0e-01); leapfrog: not finite")),
    ("accurate at = 1e-3", "", [made("euler", 1, state_error=0.5, evaluations=5)],
     "no method reached a relative error 0.001"),
    ("order", "", [
        *(made("rk4", h, state_error=3 * h**4) for h in (0.1, 0.05, 0.025)),
        *(made("euler", h, state_error=h) for h in (0.1, 0.05)), lost("heun-2", 0.1, "not finite"),
    ], "order seen: rk4 4.0, euler 1.0; heun-2: not finite"),
    ("ended", "[20]", [
        made("rk4", 1), lost("euler", 1, "not finite"), made("heun-2", 1, energy_error=2.0),
    ], "completed: rk4; lost: heun-2; not finite: euler"),
    ("ended", "", [
        made("rk4", 1), made("rk4", 2), lost("euler", 1, "not finite"), made("heun-2", 1),
        lost("heun-2", 2), lost("leapfrog", 1), made("leapfrog", 2),
    ], ("completed: rk4 at every h, euler at none (not finite), heun-2 to h = 1 (lost at 2), "
       "leapfrog but for h = 1 (lost)")),
    ("law", "[20]", [
        made("rk4", 1, law={"kind": "linear", "exponent": 1.0, "largest": 1e-3}),
        made("gauss-2", 1, law={"kind": "bounded", "exponent": 0.01, "largest": 1e-8}),
        made("euler", 1, law={"kind": "blow-up", "exponent": None, "largest": 2.0}),
        lost("leapfrog", 1, "not applicable"),
    ], ("bounded: gauss-2 (t^0.01, 1.0e-08); linear: rk4 (t^1.00, 1.0e-03); blow-up: euler; "
       "leapfrog: not applicable")),
    ("rigid-body", "", [
        made("rk4", 0.1, drifts=[DRIFT], steps=10),
        made("g6245", 0.1, drifts=[DRIFT, {**DRIFT, "kind": "form", "largest": 2e-15}], steps=10),
    ], "kept to 2.0e-15 over 10 steps: g6245; not kept: rk4 (1.0e-03)"),
]  # fmt: skip


@pytest.mark.parametrize(("which", "grid", "records", "told"), ANSWERS)
def test_an_answer_is_told_from_the_records(tmp_path, which, grid, records, told):
    kind, _, more = which.partition(" ")
    if kind in names():
        scene = load_scene(kind)
    else:
        asked = '"energy", "law"' if kind == "law" else ASKED
        scene = scene_with(tmp_path, kind, *more.splitlines(), ask=asked, grid=grid or "[20, 40]")
    found = answer(scene, records)
    assert found.startswith(told) if told.startswith("no method") else found == told


def test_losses_and_predictions_are_told():
    scene = load_scene("parasitism")
    records = [
        made("gsymplectic-p", 0.1, lost=13.8, predicted=13.7473, steps=1000),
        made("g6245", 0.1, lost=None, steps=1_000_000),
        made("s5i1-i", 0.1, lost=None, predicted=None, saturates=6.2e-3, steps=1000),
    ]
    assert answer(scene, records) == (
        "lost: gsymplectic-p at t = 13.8 (predicted 13.75); "
        "bounded to t = 100000 (1,000,000 steps): g6245, "
        "s5i1-i (predicted: the energy error stays near 0.006)"
    )
    for record in records:  # of a copy of the scene that ends earlier
        record["task"]["t_end"] = 1e3
    assert "bounded to t = 1000 (1,000,000 steps)" in answer(scene, records)


def test_a_law_is_asked_measured_and_shown(tmp_path):
    scene = scene_with(tmp_path, "law", ask='"energy", "law"', grid="[400]")
    records = run(scene)
    assert {r["law"]["quantity"] for r in records} == {"energy"}
    assert rows(scene, records)[0]["law"] in ("bounded", "random walk", "linear", "quadratic")
    assert charts(scene, records)[0].y_label == "relative drift so far"


@pytest.mark.parametrize("name", names())
def test_no_record_at_all_gives_an_answer_in_one_line(name):
    assert "\n" not in answer(load_scene(name), [])


def test_charts_show_error_against_time_and_against_evaluations(tmp_path):
    scene = loaded(tmp_path)
    time, evaluations = charts(scene, run(scene))
    assert (time.x_label, evaluations.suffix) == ("seconds", "-evaluations")
    assert [len(line.points) for line in evaluations.series] == [2, 2]
    assert evaluations.series[0].points[0][0] == 80


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (SMALL, "name\n", "not TOML: expected '=' after a key"),
        (OSCILLATOR, '"blow-up"', "line 8: the problem 'blow-up' has one component"),
        ("[20, 40]", f"[20, {'1' * 5000}]", "line 6: a value cannot be read (Exceeds the limit"),
        ("repeats = 1", f"budget = '{'1' + '+0' * 50}'", "positive number or an expression"),
        ("repeats = 1", "#" * (200_012 - len(SMALL)), "200001 bytes"),
        ("repeats = 1", f"a{'.a' * 101} = 1", "a key has more than 100 parts"),
        (GRID, f"steps = {list(range(1, MOST_ENTRIES + 2))}", "make several scenes"),
        ("A small scene", "x" * (MAX_TEXT + 1), f"more than {MAX_TEXT} characters"),
        ('name = "small"', f'name = "{"x" * (MAX_NAME + 1)}"', f"at most {MAX_NAME} characters"),
        # tar pits, refused at once
        ("repeats = 1", "x = " + "9" * 5000, "line 9: a value cannot be read"),
        ("repeats = 1", "a." * 50_000 + "a = 1", "a key has more than 100 parts"),
        ("repeats = 1", '"a".' * 40_000 + "a = 1", "a key has more than 100 parts"),
        ('t_end = "2*pi"', "t_end = " + "9" * 400, "`t_end` must be a positive number"),
        ("2*pi", "-" * 20_000 + "1", "`t_end` must be a positive number"),
        ('name = "small"', 'name = "../../x"', "`name` must be lower-case words"),
        ('"rk4"', '"../../../etc/passwd"', "../../../etc/passwd"),
        ("repeats = 1", "x = '''\n[" + " " * 100_000 + "\n'''", "the key 'x' is unknown"),
    ],
)  # fmt: skip
def test_what_does_not_fit_or_is_just_beyond_a_limit_is_refused(tmp_path, old, new, message):
    text = ORBIT if "blow-up" in new else SMALL
    error = refused(DataError, "", load_scene, write(tmp_path, text.replace(old, new, 1)))
    assert message in error and error.startswith("small.toml: ") and len(error) < 1000


def test_what_is_just_inside_the_limits_is_read(tmp_path):
    text = SMALL.replace("steps = [20, 40]", f"h = ['2*pi/{MOST_STEPS}']")
    text = text.replace("repeats = 1", f"repeats = 1000\nbudget = '1.{'+0' * 49}'")
    text = text.replace("A small scene", "x" * MAX_TEXT)
    text = text.replace('"small"', f'"{"x" * MAX_NAME}"')
    scene = load_scene(write(tmp_path, text + "#" * (200_000 - len(text))))
    assert scene.grid[0][1] == MOST_STEPS and (scene.repeats, scene.budget) == (1000, 1)
    assert len(scene.name) == MAX_NAME and len(scene.title) == MAX_TEXT


def test_a_line_of_many_points_is_no_long_key(tmp_path):
    sizes = ", ".join(f"'2.0*pi/{n}'" for n in range(1, 150))
    scene = load_scene(write(tmp_path, SMALL.replace("steps = [20, 40]", f"h = [{sizes}]")))
    assert len(scene.grid) == 149


def test_what_a_scene_leaves_out_is_what_the_page_says(tmp_path):
    text = "\n".join(x for x in SMALL.splitlines() if not x.startswith(("repeats", "at =")))
    scene = load_scene(write(tmp_path, text))
    assert (scene.repeats, scene.budget, scene.renew, scene.start) == (3, 10, 0, None)
    assert (scene.answer.error, scene.answer.at) == ("state", 1e-9)
