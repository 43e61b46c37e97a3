"""The judge accepts what is proved and refuses every change of a number in it."""

import copy
import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

from glmref import judge
from glmref.judge.arithmetic import Interval
from glmref.judge.command import main
from glmref.judge.document import Method
from glmref.judge.fields import Numbers
from glmref.judge.grammar import parse
from glmref.judge.linalg import identity
from glmref.judge.numbers import Box, apart, live, may_vanish, real, sign, squared, vanishes
from glmref.judge.refusals import Refused, Undecided
from glmref.judge.rules_symplectic import unit_forms
from glmref.judge.trees import show, trees
from tests.build import refused, tower_of_root
from tests.inside import at, texts
from tests.inside import changed as changed_at

ROOT = Path(__file__).resolve().parents[2]

SQRT3 = tower_of_root(3, "1", "2")
RATIONAL = {"kind": "rational"}


def document(path):
    return json.loads((ROOT / "data" / path).read_text(encoding="utf-8"))


def certificate(doc, claim, parts, field=RATIONAL, verdict="holds", declared=None):
    """Return a certificate with what is needed of a document."""
    doc = {key: value for key, value in doc.items() if key not in ("source", "title")}
    declared = doc["claims"][claim] if declared is None else declared
    doc["claims"] = {claim: declared}
    return {
        "format": "glmref-certificate-1",
        "statement": {"method": doc["name"], "claim": claim, "declared": declared, "verdict": verdict, "proof": "exact"},
        "document": doc, "field": field, "identities": [],
        "parts": [{"rule": rule, "witness": witness} for rule, witness in parts],
    }  # fmt: skip


def order_parts(order, tree, principal="identity"):
    series = {"order": order, "principal": principal, "trees": "all"}
    return [("order-at-least", series), ("order-at-most", {**series, "tree": tree})]


RK4 = document("methods/rk/rk4.json")
GAUSS = document("methods/rk/gauss-2.json")
LEAPFROG = document("methods/lmm/leapfrog.json")
METHOD_N = document("methods/glm/gsymplectic-n.json")
TRAPEZOIDAL = document("methods/rk/lobatto-iiia-2.json")
EIGEN_N = {"which": "o", "zeta": ["1", "-1"]}
DIAGONAL_N = {"G": METHOD_N["G"], "D": METHOD_N["D"]}
CERTIFICATES = {
    "rk4 order": certificate(RK4, "order", order_parts(4, "[oooo]")),
    "rk4 abscissae": certificate(RK4, "abscissae", [("abscissae", {})]),
    "rk4 order fails": certificate(RK4, "order", order_parts(4, "[oooo]"), verdict="fails", declared=5),
    "gauss-2 order": certificate(GAUSS, "order", order_parts(4, "[oooo]"), SQRT3),
    "gauss-2 stage order": certificate(
        GAUSS, "stage-order",
        [*order_parts(4, "[oooo]"), ("stage-order-at-least", {"q": 2}), ("stage-order-at-most", {"q": 2, "tree": "[oo]"})], SQRT3),
    "gauss-2 symplectic": certificate(GAUSS, "symplectic", [("quadratic", {})], SQRT3),
    "gauss-2 symmetric": certificate(GAUSS, "symmetric", [("symmetric", {"L": [["1"]], "P": [1, 0]})], SQRT3),
    "leapfrog error": certificate(LEAPFROG, "error-constant", [("error-constant", {})]),
    "leapfrog order-identity": certificate(
        LEAPFROG, "order-identity",
        order_parts(2, "[oo]")),
    "leapfrog zero-stable": certificate(
        LEAPFROG, "zero-stable", [("bounded", {"which": "o"})]),
    "N order-identity": certificate(
        METHOD_N, "order-identity", order_parts(4, "[oooo]"), SQRT3),
    "N g-symplectic": certificate(METHOD_N, "g-symplectic", [("form", DIAGONAL_N)], SQRT3),
    "N symmetric": certificate(
        METHOD_N, "symmetric", [("symmetric", {"L": [["1", "0"], ["0", "1"]], "P": [1, 0]})], SQRT3),
    "N growth": certificate(
        METHOD_N, "growth", [("eigen", EIGEN_N), ("growth", {})], SQRT3),
    "trapezoidal a-stable": certificate(
        TRAPEZOIDAL, "a-stable", [("bounded", {"which": "o"}), ("a-stable", {})]),
    "rk4 not a-stable": certificate(RK4, "a-stable", [("not-a-stable", {"infinity": True})], declared=False),
    "rk4 explicit": certificate(RK4, "explicit", [("explicit", {})]),
}  # fmt: skip


def answer(value):
    return judge.verdict(value)


@pytest.mark.parametrize("name", CERTIFICATES)
def test_accepted(name):
    accepted, why = answer(CERTIFICATES[name])
    assert accepted, why


def test_series_satisfy_their_tree_counts():
    single = (("o", "o"),)
    assert [len(trees(single, n)) for n in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]
    alternating = (("f", "k"), ("k", "f"))
    assert [len(trees(alternating, n)) for n in range(1, 7)] == [2, 2, 4, 8, 18, 40]


def changed(name, change):
    value = copy.deepcopy(CERTIFICATES[name])
    change(value)
    return value


def witness(value, k=0):
    return value["parts"][k]["witness"]


REFUSED = {
    "another order": ("rk4 order", lambda v: witness(v).update(order=3)),
    "a claim of order 5": ("rk4 order", lambda v: v["statement"].update(declared=5)),
    "a tree at which the condition holds": ("N order-identity", lambda v: witness(v, 1).update(tree="[o[o][o]]")),
    "a tree of another order": ("N order-identity", lambda v: witness(v, 1).update(tree="[ooo]")),
    "a tree left out": ("N order-identity", lambda v: witness(v, 1).pop("tree")),
    "an eigenvalue left out": ("N growth", lambda v: witness(v)["zeta"].pop()),
    "an eigenvalue twice": ("N growth", lambda v: witness(v)["zeta"].append("1")),
    "no eigenvalue": ("N growth", lambda v: witness(v)["zeta"].append("sqrt(3)-2")),
    "a part left out": ("gauss-2 order", lambda v: v["parts"].pop()),
    "a part too many": ("gauss-2 symplectic", lambda v: v["parts"].append(v["parts"][0])),
    "an unknown key": ("rk4 order", lambda v: v.update(note="x")),
    "an unknown key of a witness": ("rk4 order", lambda v: witness(v).update(note="x")),
    "an unknown key of the document": ("rk4 order", lambda v: v["document"].update(c=["0"])),
    "an unknown rule": ("rk4 order", lambda v: v["parts"][0].update(rule="order")),
    "the other verdict": ("rk4 order", lambda v: v["statement"].update(verdict="fails")),
    "another method": ("rk4 order", lambda v: v["statement"].update(method="rk38")),
    "a float": ("rk4 order", lambda v: witness(v).update(order=4.0)),
    "the other root": ("gauss-2 order", lambda v: v["field"]["generators"][0].update(real=["-2", "-1"])),
    "a box with both roots": ("gauss-2 order", lambda v: v["field"]["generators"][0].update(real=["-2", "2"])),
    "a box without a root": ("gauss-2 order", lambda v: v["field"]["generators"][0].update(real=["2", "3"])),
    "another polynomial": ("gauss-2 order", lambda v: v["field"]["generators"][0].update(polynomial=["-2", "0"])),
    "a radical of the other sign": ("gauss-2 order", lambda v: v["field"]["radicals"].update({"sqrt(3)": "-g1"})),
    "another principal part": ("rk4 order", lambda v: [witness(v, k).update(principal="free") for k in (0, 1)]),
    "another G than in the file": ("N g-symplectic", lambda v: witness(v).update(G=[["0", "0"], ["0", "0"]])),
    "no involution": ("gauss-2 symmetric", lambda v: witness(v).update(P=[1, 1])),
    "shapes": ("gauss-2 symmetric", lambda v: witness(v).update(L=[["1", "0"]])),
    "a stage that needs a later one": ("rk4 explicit", lambda v: v["document"]["A"][1].__setitem__(2, "1/7")),
    "a multiple root on the circle": ("leapfrog zero-stable", lambda v: v["document"].update(alpha=["1", "-2", "1"])),
    "a root outside the circle": ("leapfrog zero-stable", lambda v: v["document"].update(alpha=["-2", "1", "1"])),
    "beyond the limits": ("rk4 order", lambda v: witness(v).update(order=10**9)),
    "huge numbers": ("rk4 abscissae", lambda v: v["document"].update(b=["9" * 5000] * 4)),
    "deep parentheses": ("rk4 abscissae", lambda v: v["document"].update(b=["(" * 1900 + "1" + ")" * 1900] * 4)),
}  # fmt: skip


@pytest.mark.parametrize("reason", REFUSED)
def test_refused(reason):
    name, change = REFUSED[reason]
    accepted, why = answer(changed(name, change))
    assert not accepted, why


def test_an_unstable_method_is_not_called_stable():
    doc = document("broken/bdf-7.json")
    v = {"which": "o"}
    assert answer(
        certificate(doc, "zero-stable", [("unbounded", v)], verdict="fails", declared=True)
    )[0]
    stable = certificate(
        LEAPFROG, "zero-stable", [("unbounded", v)], verdict="fails", declared=True
    )
    assert not answer(stable)[0]


def test_a_pole_at_minus_one_is_seen():
    """Radau-like method with det(I - z A) = 1 + z: not A-stable."""
    doc = {"name": "p", "class": "rk", "A": [["-1"]], "b": ["1"], "claims": {"a-stable": True}}
    bounded = ("bounded", {"which": "o"})
    assert not answer(certificate(doc, "a-stable", [bounded, ("a-stable", {})]))[0]
    doc["claims"] = {"a-stable": False}
    assert answer(certificate(doc, "a-stable", [("not-a-stable", {"pole": True})]))[0]


# ------------------------------------------------------------------------- changed numbers

# Places where a number stands in identities only, so that a change makes one of them false.
# The weights of a list of abscissae are not among them (their sum counts), nor is the q of a
# bounded V (-q does as well).
PLACES = {
    "rk4 order": [("document", "A"), ("document", "b")],
    "rk4 abscissae": [("document", "claims", "abscissae")],
    "gauss-2 order": [("document", "A"), ("document", "b")],
    "gauss-2 symplectic": [("document", "b")],
    "gauss-2 symmetric": [("document", "A")],
    "leapfrog error": [("document", "beta"), ("document", "claims", "error-constant")],
    "leapfrog order-identity": [("document", "beta"), ("document", "alpha")],
    "N order-identity": [("document", "B"), ("document", "A")],
    "N g-symplectic": [("document", "U"), ("document", "B"), ("parts", 0, "witness", "G"), ("parts", 0, "witness", "D")],
    "N growth": [("parts", 0, "witness", "zeta"), ("document", "claims", "growth")],
}  # fmt: skip


@pytest.mark.parametrize("name", PLACES)
def test_a_changed_number_is_refused(name):
    sound = CERTIFICATES[name]
    for path in (x for place in PLACES[name] for x in texts(at(sound, place), place)):
        for new in (f"({at(sound, path)})+1/97", f"({at(sound, path)})-1/1{'0' * 40}"):
            value = changed_at(sound, path, new)
            statement, claims = value["statement"], value["document"]["claims"]
            statement["declared"] = claims[statement["claim"]]
            assert not answer(value)[0], (path, new)


# ------------------------------------------------------------------------------- the command


def run(*files):
    return subprocess.run(
        [sys.executable, "-m", "glmref.judge", *map(str, files)],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_exit_codes(tmp_path):
    good, bad, broken = (tmp_path / f"{name}.json" for name in ("good", "bad", "broken"))
    good.write_text(json.dumps(CERTIFICATES["rk4 order"]), encoding="utf-8")
    bad.write_text(json.dumps(changed(*REFUSED["another order"])), encoding="utf-8")
    broken.write_text("{", encoding="utf-8")
    assert run(good).returncode == 0
    refused = run(good, bad)
    assert refused.returncode == 1
    assert [line.split(": ")[1] for line in refused.stdout.splitlines()] == ["yes", "no"]
    unreadable = run(broken)
    assert (unreadable.returncode, len(unreadable.stderr.splitlines())) == (2, 1)
    assert run(tmp_path / "missing.json").returncode == 2


@pytest.mark.parametrize(
    "text", ['"identities": [], "identities": []', '"identities": [1.5]', '"identities": [NaN]']
)
def test_twins_and_floats_are_refused(tmp_path, text):
    path = tmp_path / "c.json"
    path.write_text(
        json.dumps(CERTIFICATES["rk4 order"]).replace('"identities": []', text), encoding="utf-8"
    )
    assert run(path).returncode == 1


@pytest.mark.slow
def test_a_file_may_hold_one_certificate_on_each_line(tmp_path):
    """As ``glmref certify NAME`` prints them; one that is refused decides the exit code."""
    good = json.dumps(CERTIFICATES["rk4 order"])
    bad = json.dumps(changed(*REFUSED["another order"]))
    path = tmp_path / "lines.json"
    path.write_text(f"{good}\n\n{good}\n")
    found = run(path)
    assert (found.returncode, found.stdout.count(": yes: rk4: order = 4")) == (0, 2)
    path.write_text(f"{good}\n{bad}\n")
    found = run(path)
    assert (found.returncode, found.stdout.count(": yes: "), found.stdout.count(": no: ")) == (
        1,
        1,
        1,
    )
    path.write_text(f"{good}\n{{}} }}\n")
    assert run(path).returncode == 2


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda c: c.pop("parts"), "the certificate has no key 'parts'"),
        (lambda c: c.update(more=1), "the certificate has an unknown key 'more'"),
        (lambda c: c["statement"].update(method=None), "the method of the statement is no string"),
        (
            lambda c: (c["statement"].update(method=None), c["document"].pop("name")),
            "the method of the statement is no string",
        ),
        (lambda c: c["document"].pop("name"), "the document has another name"),
        (lambda c: c["statement"].update(verdict="open"), "the verdict is not holds or fails"),
        (
            lambda c: c["statement"].update(claim=["order"]),
            "the claim of the statement is no string",
        ),
        (lambda c: c.update(document=None), "the document is no object"),
        (lambda c: c.update(field=None), "the field is no object"),
        (lambda c: c.update(field={}), "the field has no kind"),
        (lambda c: c.update(parts={}), "the parts are no list of 1 to 20"),
        (lambda c: c["parts"].append(None), "the part is no object"),
        (lambda c: c["parts"][0].update(witness=None), "a witness is no object"),
        (lambda c: c["parts"][0].update(rule=["row"]), "no rule is called"),
        (lambda c: c.update(identities="x"), "the identities are no list of strings"),
    ],
)
def test_what_has_not_the_members_of_a_certificate_is_none(tmp_path, capsys, change, sentence):
    value = copy.deepcopy(CERTIFICATES["rk4 order"])
    change(value)
    path = tmp_path / "c.json"
    path.write_text(json.dumps(value), encoding="utf-8")
    assert main([str(path)]) == 2
    found = capsys.readouterr()
    assert found.out == "" and found.err.startswith(f"{path}: no certificate: {sentence}")
    assert found.err.count("\n") == 1
    assert not judge.verdict(value)[0]


@pytest.mark.parametrize(
    "name", ["a\nb.json: yes: c", "\x1b[2J", "\ud800", "\u202e", "\x85", "x" * 9999]
)
def test_a_name_makes_no_answer_of_its_own(tmp_path, name):
    certificate = json.loads(
        json.dumps(CERTIFICATES["rk4 order"]).replace('"rk4"', json.dumps(name))
    )
    path = tmp_path / "c.json"
    path.write_text(json.dumps(certificate), encoding="utf-8")
    found = run(path)
    assert (found.returncode, found.stderr) == (0, "")
    (line,) = found.stdout.splitlines()
    assert line.isprintable() and len(line) < 1000


def test_no_form_where_there_is_one_is_refused():
    """Explicit Euler: D A + A^* D - B^* G B is -G for D = 0, and 0 for G = 0; the midpoint rule has a form."""
    doc = document("methods/lmm/ab-1.json")
    assert answer(certificate(doc, "g-symplectic", [("no-form", {})]))[0]
    doc = {
        "name": "m",
        "class": "rk",
        "A": [["1/2"]],
        "b": ["1"],
        "claims": {"g-symplectic": False},
    }
    assert (
        "u^* G u is a linear combination"
        in answer(certificate(doc, "g-symplectic", [("no-form", {})]))[1]
    )


def test_a_refusal_quotes_little_of_what_it_refuses():
    doc = document("methods/rk/rk4.json") | {"class": "x" * 10_000}
    accepted, sentence = judge.verdict(certificate(doc, "order", order_parts(4, "[o]"), declared=4))
    assert not accepted and sentence.startswith("no class is called 'xxx") and len(sentence) < 210


def test_the_basis_of_forms_of_a_separable_pair_is_complete():
    method = Method(document("methods/partitioned/stormer-verlet.json"), Numbers(RATIONAL))
    slopes = [len(m.B[0]) for m in method.parts.values()]
    units = [P + Q for G, (P, Q) in unit_forms(method) if vanishes(G)]
    assert units == identity(sum(slopes))


THIRD = {
    "kind": "tower",
    "generators": [{"name": "g1", "polynomial": ["1", "1"], "real": ["-501/1000", "-499/1000"],
                    "imag": ["866/1000", "867/1000"], "conjugate": "-1-g1"}],
}  # fmt: skip


@pytest.mark.parametrize(
    ("text", "value", "other"),
    [("exp(0)", "1", "-1"), ("exp(0/3)", "1", "g1"), ("exp(2*pi*i/3)", "g1", "-1-g1"),
     ("exp(-(-2*i*pi)/3)", "g1", "1"), ("exp(2/3*pi*i)", "g1", "-1-g1"), ("exp(4*i/3*pi)", "-1-g1", "g1")],
)  # fmt: skip
def test_roots_of_unity_in_several_spellings(text, value, other):
    Numbers({**THIRD, "radicals": {text: value}})
    refused(Refused, "is another number", Numbers, {**THIRD, "radicals": {text: other}})


@pytest.mark.parametrize(
    "angle",
    ["2*pi*pi*i/3", "2*i/3", "2*i/pi/3", "2*pi/i/3", "2*pi*i/3+0", "2*(pi+0)*i/3", "2*pi*i*i*i/3",
     "2*pi*i*sqrt(1)/3", "2*pi*i*3/0", "0/0", "2**1*pi*i/3", "2*pi_*i/3", "1-1", "0+pi", ""],
)  # fmt: skip
def test_angles_that_are_no_product_with_one_pi_and_one_i_are_refused(angle):
    for value in ("1", "g1"):
        refused(Refused, "", Numbers, {**THIRD, "radicals": {f"exp({angle})": value}})


def rectangle(*ends):
    """A rectangle with these rational ends: left, right, low, high."""
    left, right, low, high = map(Fraction, ends)
    return Box(Interval.ends(left, right), Interval.ends(low, high))


HALF = Fraction(1, 2)


def test_a_rectangle_around_0_decides_nothing():
    """Neither that the number is 0 nor that it is not."""
    around_0 = rectangle(-HALF, HALF, -HALF, HALF)
    assert not apart(around_0) and may_vanish(around_0) and live(around_0)
    for question in (bool, vanishes, sign, lambda x: x == around_0):
        refused(Refused, "", question, around_0)
    refused(Undecided, "", bool, around_0)


@pytest.mark.parametrize("ends", [(3, 4, -1, 1), (-1, 1, 3, 4), (1, 2, -2, -1)])
def test_a_rectangle_without_0_is_no_zero(ends):
    found = rectangle(*ends)
    assert apart(found) and bool(found) and not may_vanish(found) and not vanishes(found)
    assert sign(squared(found)) == 1
    assert type(real(found)) is Interval


def test_a_complex_number_times_an_interval_is_a_rectangle():
    """In either order; a real number times an interval stays an interval."""
    number = Numbers({**THIRD, "radicals": {}}).number
    near_1 = Interval.ends(Fraction(99, 100), Fraction(101, 100))
    z = number("g1")
    for found in (z * near_1, near_1 * z, z + (near_1 - 1), (near_1 - 1) + z):
        assert type(found) is Box
        assert not apart(found - z) and apart(found - (-1 - z)) and apart(found)
        assert not apart(found * z - (-1 - z)) and not apart(z * found - (-1 - z))
    root = Numbers(tower_of_root(2, "1", "2")).number("g1")
    assert {type(x) for x in (root * near_1, near_1 * root, root + near_1)} == {Interval}


def test_a_part_about_stages_leaves_nothing_behind_that_an_order_is_judged_with():
    """Stages are looked at before the principal parts of their order are known."""
    rk = document("methods/rk/butcher-effective-5.json")
    s = len(rk["b"])
    doc = {
        "name": "effective-5-beside-0", "format": "glmref-method-1", "class": "glm", "A": rk["A"],
        "U": [["1", "0"]] * s, "B": [rk["b"], ["0"] * s], "V": [["1", "0"], ["0", "0"]],
    }  # fmt: skip

    def about(claim, declared, verdict, *parts):
        claims = {**doc, "claims": {}}
        return certificate(claims, claim, parts, verdict=verdict, declared=declared)

    stages = ("stage-order-at-most", {"q": 3, "tree": "[[[o]]]"})
    four = about("order", 4, "holds", *order_parts(4, "[[[[o]]]]", "free"))
    others = [
        about("order", 4, "holds", *order_parts(4, f"[{show(t)}]", "free"))
        for t in trees((("o", "o"),), 4)
    ]
    for value in (four, *others):
        assert answer(about("stage-order", 6, "fails", stages))[0]
        assert not answer(value)[0]


@pytest.mark.parametrize(
    "text",
    ["", " ", "1 2", "(1", "1)", "*1", "1+", "1-", "2/", "sqrt 2", "sqrt", "root(2)", "f(2)", "2^3",
     "1//2", "2**3", "1_000", "0x10", "1e5", "1j", "a.b", "1,2", "()", ".", "1.5", "i", "sqrt(4)",
     "x", "1/0", "(" * 101 + "1" + ")" * 101, "-" * 101 + "1", "1" * 4001, 5, None],
)  # fmt: skip
def test_what_is_no_rational_entry_is_refused(text):
    with pytest.raises(Refused):
        parse(text, lambda name: None)


@pytest.mark.parametrize(
    ("text", "value"),
    [("007", 7), (" 1 / 2\t", Fraction(1, 2)), ("1-2-3", -4), ("1+2-3", 0), ("2/3*4", Fraction(8, 3)),
     ("8/2/2", 2), ("-2*3", -6), ("--1", 1), ("+-1", -1), ("2*-3", -6), ("(1-2)*3", -3), ("1-2*3", -5),
     ("(" * 100 + "1" + ")" * 100, 1), ("-" * 100 + "1", 1), ("(1)+" * 200 + "1", 201)],
)  # fmt: skip
def test_entries_have_their_value(text, value):
    assert parse(text, lambda name: None) == value


def test_constants_are_written_out_in_radicals_only():
    seen = []
    found = parse("c*root(c + sqrt(01), 3)", {"c": Fraction(2)}.get,
                  lambda text: seen.append(text) or Fraction(5), {"c": "d-1", "d": "3"})  # fmt: skip
    assert found == 10 and seen == ["root(((3)-1)+sqrt(1),3)"]
