"""Exports: what is refused, what comments say; imports: foreign tables, and what is no table."""

import ast
import os
from fractions import Fraction
from pathlib import Path
from time import process_time

import pytest

import glmref
from glmref.catalogue.reader import load_document
from glmref.cli import exchanging, main
from glmref.errors import DataError, UsageError
from glmref.exchange import import_tables
from glmref.exchange.export import TARGETS, export
from glmref.exchange.header import Comment, header
from glmref.exchange.import_tables import read_table
from glmref.exchange.scheme import scheme_of
from glmref.exchange.steppers import LANGUAGES
from glmref.method import GLM, AdditiveGLM
from tests.build import refused


def test_the_command_line_offers_what_the_package_writes_and_reads() -> None:
    from glmref.exchange.tables import FORMATS

    assert exchanging.TARGETS == TARGETS
    assert exchanging.READ == import_tables.READ
    assert set(TARGETS) == {*LANGUAGES, *FORMATS, "json", "csv"}
    assert len(TARGETS) >= 12


@pytest.mark.parametrize("target", TARGETS)
def test_every_target_names_method_source_and_version(target: str) -> None:
    text = export("heun-2", to=target)
    assert "heun-2" in text
    assert "Heun, K." in text
    assert f"glmref {glmref.__version__}" in text or target in ("json", "csv")


@pytest.mark.parametrize(
    ("name", "target", "absent"),
    [
        ("dormand-prince-8-5-3", "sundials", ["the embedded row order-3"]),
        ("dormand-prince-5-4", "c", ["the embedded row embedded", "the dense output"]),
        ("dormand-prince-5-4", "rungekutta.jl", ["the embedded row embedded", "the dense output"]),
        ("dormand-prince-5-4", "latex", ["the dense output"]),
        ("dormand-prince-5-4", "json", []),
        ("multistep-10", "latex", ["the starting method", "the output of q", "the output of p"]),
        ("rk4", "petsc", []),
    ],
)
def test_what_is_left_out_is_named_in_the_comment_and_on_stderr(name, target, absent, cli):
    out, err = cli("export", name, "--to", target)
    comment = " ".join(out.replace("*", "").replace("#", "").replace("%", "").split())
    assert (f"Left out: {', '.join(absent)}." in comment) == bool(absent)
    said = f"glmref: {name}: left out of what is written: {', '.join(absent)}\n"
    assert err == (said if absent else "")


def test_latex_of_a_multistep_method_has_alpha_and_beta() -> None:
    """Of a file, and of a method made by hand; a Runge-Kutta method has none."""
    ab = glmref.from_lmm(alpha=[0, -1, 1], beta=["-1/2", "3/2", 0])
    for method in ("ab-2", ab):
        text = export(method, to="latex")
        assert r"  \alpha_m & 0 & -1 & 1 \\" in text
        assert r"  \beta_m & -\frac{1}{2} & \frac{3}{2} & 0 \\" in text
    assert "alpha" not in export("rk4", to="latex")


def test_diffrax_gets_the_error_estimate() -> None:
    text = export("bogacki-shampine-3-2", to="diffrax")
    assert (
        "b_error=np.array(\n        [\n            -5.0 / 72, 1.0 / 12, 1.0 / 9, -1.0 / 8" in text
    )
    assert "difference to a solution of order 2" in text
    for name in ("bogacki-shampine-3-2", "dormand-prince-8-5-3"):
        method = glmref.load(name)
        document = import_tables.read_table(export(method, to="diffrax"), "diffrax")
        (row,) = load_document(document).embedded
        (given, *_) = method.embedded
        ((own,),), ((other,),) = row.estimate(method.weights), given.estimate(method.weights)
        assert all((x - y).is_zero() is True for x, y in zip(own, other, strict=True))
    plain = import_tables.read_table(export("heun-3", to="diffrax"), "diffrax")
    assert "embedded" not in plain
    assert "No embedded method" in export("heun-3", to="diffrax")


def test_additive_methods_go_where_they_can_be_held() -> None:
    with pytest.raises(
        UsageError, match="ars-4-4-3 is additive: petsc, sundials, json, csv and latex hold"
    ):
        export("ars-4-4-3", to="julia")
    text = export("ars-4-4-3", to="petsc")
    assert 'TSARKIMEXRegister("ars-4-4-3", 3, 5, At, bt, ct, A, b, c,' in text
    tables = export("ars-4-4-3", to="sundials")
    assert "ARKStepSetTables(arkode_mem, 3, 0, Bi, Be)" in tables
    implicit = [["1/2", "0"], ["0", "1/2"]]
    both = AdditiveGLM(A=[implicit, implicit], B=[[["1/2", "1/2"]]] * 2, name="mine")
    refused(UsageError, "mine has no such parts", export, both, to="petsc")
    turned = AdditiveGLM(A=[[["1"]], [["0"]]], B=[[["1"]]] * 2, name="mine", claims={"order": 1})
    assert "A, b, c: part 2, explicit; At, bt, ct: part 1" in export(turned, to="petsc")
    wrong = text.replace("1.0/2.0, 2.0/3.0, 1.0/2.0, 1.0", "1.0/2.0, 2.0/3.0, 1.0/4.0, 1.0")
    assert wrong != text
    refused(DataError, "no sum of row 4 of A", import_tables.read_table, wrong, "petsc")


@pytest.mark.parametrize("name", ["stormer-verlet", "position-verlet", "ruth-3", "forest-ruth-4"])
def test_a_table_of_sprkstep_makes_the_steps_of_the_splitting(name: str) -> None:
    """In each stage p += ahat_i h k(q), then q += a_i h f(p)."""
    import math

    text = export(name, to="sundials")
    a, ahat = (
        [eval(x, {"SUN_RCONST": float}) for x in import_tables._c_array(text, [letter]) or ()]
        for letter in ("a", "ahat")
    )
    q, p = 1.0, 0.25
    for _ in range(20):
        for drift, kick in zip(a, ahat, strict=True):
            p -= kick * 0.1 * math.sin(q)
            q += drift * 0.1 * p
    stepper: dict = {}
    exec(export(name, to="python"), stepper)
    other = stepper["integrate"](lambda p: p, lambda q: [-math.sin(q[0])], 0.1, 20, [1.0], [0.25])
    assert [q, p] == pytest.approx([other[0][0], other[1][0]], rel=1e-13)


def test_a_sprk_table_written_by_somebody_else_is_read() -> None:
    text = "sunrealtype a[2] = {0.5, 0.5}, ahat[2] = {0.0, 1.0};\nARKodeSPRKTable_Create(2, 2, a, ahat);"
    document = import_tables.read_table(text, "sundials")
    assert (document["class"], document["first"]) == ("splitting", "q")
    assert (document["a"], document["b"]) == (["1/2", "1/2"], ["1"])
    assert all(x.verdict.name == "HOLDS" for x in glmref.verify(load_document(document)))
    with pytest.raises(DataError, match="of one length"):
        import_tables.read_table(text.replace("0.5, 0.5", "0.5"), "sundials")


def test_a_method_with_several_values_and_no_start_is_refused() -> None:
    """Its first value is not the solution, so that the enhanced start does not apply."""
    V, U = [["1", "0"], ["0", "1/2"]], [["0", "1"]]
    method = GLM(A=[["0"]], U=U, B=[["1"], ["1"]], V=V, name="mine")
    refused(UsageError, "mine carries 2 values and has no starting method", export, method, to="c")


def test_a_computed_method_without_a_name_is_exported() -> None:
    method = GLM(A=[["0"]], U=[["1"]], B=[["1"]], V=[["1"]])
    assert "method_integrate" in export(method, to="c")
    assert "Tableau{T}(:method, 1, 1, a, b, c)" in export(method, to="rungekutta.jl")


def test_a_citation_cannot_end_a_comment_nor_add_lines_to_it() -> None:
    source = {
        "citation": 'a */ int x; /* b\n#include "y" """ z\\',
        "where": "p",
        "status": "derived",
    }
    method = GLM(A=[["0"]], U=[["1"]], B=[["1"]], V=[["1"]], name="sly", source=source)
    body = header(method, "c", Comment("/*", " * ", " */"))
    assert body.count("*/") == 1
    assert body.count("/*") == 1
    assert "\\" not in body
    assert '"""' not in body
    assert all(line.startswith(" *") for line in body.splitlines()[1:])


@pytest.mark.slow
def test_steppers_of_every_real_method_are_written_in_every_language() -> None:
    for name in (
        "rk4",
        "gauss-2",
        "ab-2",
        "g4123",
        "stormer-verlet",
        "gsymplectic-n-pair",
        "pair-4-4",
    ):
        for language in LANGUAGES:
            text = export(name, to=language)
            assert "@{" not in text
            assert not any(line.startswith("@") for line in text.splitlines())
        ast.parse(export(name, to="python"))
        ast.parse(export(name, to="jax"))


def test_stages_stand_in_the_order_of_computation_and_unread_ones_are_dropped() -> None:
    scheme = scheme_of(glmref.load("pair-rkn-6-8b"))
    assert scheme.start is not None
    for table in (scheme.step, scheme.start):
        assert set(table.blocks) == {1}
        assert all(x.is_zero() is True for i, row in enumerate(table.A) for x in row[i:])
    method = GLM(A=[["0", "1"], ["0", "0"]], U=[["1"], ["1"]], B=[["1", "0"]], V=[["1"]])
    assert scheme_of(method).step.blocks == (1, 1)
    idle = GLM(A=[["0", "0"], ["0", "0"]], U=[["1"], ["1"]], B=[["1", "0"]], V=[["1"]])
    assert scheme_of(idle).step.s == 1


def test_a_solution_that_several_values_make_is_carried_as_one_of_them() -> None:
    name, stepper = "multistep-rkn-8", {}
    assert scheme_of(glmref.load(name)).heads == (0, 1)
    exec(export(name, to="python"), stepper)
    target = glmref.problem("harmonic-oscillator")
    q, p = ([float(x)] for x in target.y0)
    found = stepper["integrate"](lambda p: p, lambda q: [-q[0]], 0.1, 5, q, p)
    expected = glmref.solve(target, name, h=0.1, steps=5).y[-1]
    assert [x for z in found for x in z] == pytest.approx(list(map(float, expected)), abs=1e-13)


@pytest.mark.peers
@pytest.mark.slow
def test_the_diffrax_class_steps_as_the_method(tmp_path: Path) -> None:
    pytest.importorskip("diffrax", reason="diffrax is not installed")
    import os
    import subprocess
    import sys

    (tmp_path / "table.py").write_text(export("heun-3", to="diffrax"), encoding="utf-8")
    script = (
        "import diffrax, jax.numpy as jnp, table, sys\n"
        "found = diffrax.diffeqsolve(diffrax.ODETerm(lambda t, y, args: y * jnp.cos(t)),\n"
        "    table.Heun3(), 0.0, 1.0, 0.125, jnp.array(1.0),\n"
        "    stepsize_controller=diffrax.ConstantStepSize())\n"
        "sys.stdout.write(repr(float(found.ys[-1])))\n"
    )
    ran = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, cwd=tmp_path,
        env={**os.environ, "JAX_ENABLE_X64": "1", "JAX_PLATFORMS": "cpu"},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    import math

    stepper: dict = {}
    exec(export("heun-3", to="python"), stepper)
    (y,) = stepper["integrate"](lambda t, y: [y[0] * math.cos(t)], 0.0, 0.125, 8, [1.0])
    assert float(ran.stdout) == pytest.approx(y, rel=1e-14)


# --- reading -------------------------------------------------------------------------------------

JULIA = """
function constructBogackiShampine3(T::Type = Float64)
    A = [0 0 0 0
         1//2 0 0 0
         0 3//4 0 0
         2//9 1//3 4//9 0]
    c = [0; 1 // 2; 3 // 4; 1]   # abscissae
    α = [2 // 9; 1 // 3; 4 // 9; 0]
    return ExplicitRKTableau(A, c, α, 3, adaptiveorder = 2)
end
"""
C = """
/* Ralston's method, as somebody writes it */
const PetscReal A[2][2] = {{0, 0}, {RCONST(2.0)/RCONST(3.0), 0}}, // rows
                b[2] = {.25, (PetscReal)0.75};
TSRKRegister("ralston", 2, 2, &A[0][0], b, NULL, NULL, 0, NULL);
"""
PYTHON = """
import numpy as np
tableau = diffrax.ButcherTableau(
    a_lower=(np.array([1 - np.sqrt(2) / 2]),), a_diagonal=np.array([0, 1 - np.sqrt(2) / 2]),
    b_sol=np.array([1 / 2, 0.5]), b_error=np.array([0.0, 0.0]), c=np.array([2 - np.sqrt(2.0)]),
)
class Mine:
    def order(self, terms):
        return 1
"""


def test_a_julia_table_written_by_somebody_else_is_read() -> None:
    document = import_tables.read_table(JULIA, "ordinarydiffeq", name="bs3")
    assert document["A"][3] == ["2/9", "1/3", "4/9", "0"]
    assert document["b"] == ["2/9", "1/3", "4/9", "0"]
    assert document["claims"] == {"order": 3, "abscissae": ["0", "1/2", "3/4", "1"]}
    findings = glmref.verify(load_document(document))
    assert [x.verdict.name for x in findings] == ["HOLDS", "HOLDS"]


def test_a_c_table_written_by_somebody_else_is_read() -> None:
    document = import_tables.read_table(C, "petsc")
    assert document["name"] == "ralston"
    assert document["A"] == [["0", "0"], ["2/3", "0"]]
    assert document["b"] == ["1/4", "3/4"]
    assert document["claims"] == {"order": 2}
    without = import_tables.read_table(C.replace("TSRKRegister", "Other"), "petsc")
    assert without["claims"] == {"explicit": True}


def test_a_python_table_written_by_somebody_else_is_read_with_its_roots() -> None:
    document = import_tables.read_table(PYTHON, "diffrax")
    assert document["A"] == [["0", "0"], ["(2-sqrt(2))/2", "(2-sqrt(2))/2"]]
    assert document["claims"] == {"order": 1, "abscissae": ["0", "2-sqrt(2)"]}


def test_long_decimals_are_rounded_numbers_and_short_ones_exact() -> None:
    text = "A[] = {0, 0, 5e-1, 0}; b[] = {3.3333333333333333e-1, 6.66666666666666666E-01};"
    document = import_tables.read_table(text, "petsc")
    assert document["A"][1][0] == "1/2"
    method = load_document(document)
    assert (method.B[0][0] - Fraction(1, 3)).is_zero() is None
    assert document["b"] == ["0.33333333333333333", "0.666666666666666666"]
    assert document["digits"] == 16


def test_a_comment_that_contradicts_the_table_is_not_believed() -> None:
    text = export("sdirk-2", to="petsc")
    assert "exact b: sqrt(2)/2" in text
    with pytest.raises(DataError, match=r"`b\[1\]\[1\]` is 0.7071.* and sqrt\(3\)/2 = 0.866"):
        import_tables.read_table(text.replace("exact b: sqrt(2)/2", "exact b: sqrt(3)/2"), "petsc")
    with pytest.raises(DataError, match="another shape"):
        import_tables.read_table(text.replace("exact b: sqrt(2)/2;", "exact b:"), "petsc")


def test_the_commands_write_files_and_say_what_is_wrong(tmp_path: Path, cli) -> None:
    table, method = tmp_path / "heun.c", tmp_path / "heun.json"
    assert main(["export", "heun-2", "--to", "petsc", "--output", str(table)]) == 0
    assert main(["import", str(table), "--from", "petsc", "--output", str(method)]) == 0
    cli("verify", method)
    assert '"b": ["1/2", "1/2"]' in cli("export", "heun-2", "--to", "json").out
    for words, reason in (
        (["export", "heun-2", "--to", "c", "--output", str(tmp_path)], "is a folder"),
        (["import", str(tmp_path / "none"), "--from", "petsc"], "cannot be read"),
        (["import", str(tmp_path), "--from", "petsc"], "it is a folder"),
        (["export", "heun-2", "--to", "cobol"], "cobol"),
        (["export", "g6245", "--to", "sundials"], "carries 4 values"),
    ):
        error = cli(*words, code=2).err
        assert reason in error
        assert error.count("\n") == 1
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in cli("import", tmp_path / "binary", "--from", "petsc", code=2).err


@pytest.mark.sampled(8)
@pytest.mark.parametrize(
    ("form", "text", "said"),
    [
        ("json", "[" * 100_000, "deep"),
        ("csv", f"name,,,{'x' * 200_000}\n", "is no CSV"),
        ("petsc", f"A[] = {{{'9' * 10**6}}}; b[] = {{1}};", "1000000 characters"),
        ("petsc", "A[] = {1e9999}; b[] = {1};", "more than 4000 digits"),
        ("rungekutta.jl", f"a = [{'1 ' * 50_000}]; b = [1]", "more than 40000 entries"),
        ("diffrax", f"ButcherTableau(c={'-' * 100_000}1)", "too deep"),
        ("sundials", "int A[] = {1};" + "/*" * 1_000_000, "no arrays"),
        ("sundials", "A[" * 1_000_000, "no arrays"),
        ("ordinarydiffeq", "#=" * 1_000_000, "no arrays"),
    ],
)
def test_a_hostile_table_is_refused_at_once(form: str, text: str, said: str) -> None:
    """In time that is linear in its length; of two values for one thing none is taken."""
    begun = process_time()
    caught = refused(DataError, "", read_table, text, form)
    assert said in caught
    assert "\n" not in caught and len(caught) < 1500
    assert process_time() - begun < 5


def test_an_import_reads_regular_files_of_bounded_size_only(tmp_path: Path, cli) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "large").write_bytes(b" " * 4_000_001)
    for name, said in (("pipe", "named pipe"), ("large", "at most"), ("/dev/zero", "a device")):
        assert said in cli("import", tmp_path / name, "--from", "petsc", code=2).err
