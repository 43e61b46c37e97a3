"""Exported steppers, compiled and run, end where the engine ends.

The tolerance: a step commits a relative error of a few units of round-off u, taken as 4 u; along an
orbit of Kepler's problem with e = 0.2 an error grows no faster than 1 + 3 t, since the period
depends on the energy. Over n steps that is n 4 u (1 + 3 n h), here 1.4e-11; with compensated
summation on both sides the difference is far smaller.
"""

import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import glmref
from glmref.exchange.export import export
from glmref.exchange.scheme import scheme_of
from glmref.exchange.steppers import identifier
from tests.shipped import shipped

HERE = Path(__file__).parent / "exported"
H, STEPS = 0.01, 1000
TOLERANCE = STEPS * 4 * 2.0**-53 * (1 + 3 * STEPS * H)

METHODS = (
    *("rk4", "gauss-2", "tr-bdf2", "thesis-3-8", "g6245-w3", "order8-s3-w3-i", "yoshida-4"),
    *("blanes-moan-rkn-6-14", "pair-rkn-6-8b", "ab-4"),
    # implicit pairs, a start that makes itself with implicit steps, a finishing method
    *("lobatto-iiia-iiib-3", "bdf-3", "g4123"),
)
STRICT = ["-Wall", "-Wextra", "-pedantic", "-Werror"]
SAFE = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover"]


def is_pair(name: str) -> bool:
    return isinstance(glmref.load(name), glmref.PartitionedGLM)


@cache
def end_of(name: str) -> list[float]:
    problem = glmref.problem("kepler", eccentricity="1/5")
    return [float(x) for x in glmref.solve(problem, name, h=H, steps=STEPS).y[-1]]


def need(program: str) -> str:
    found = shutil.which(program)
    if found is None:
        pytest.skip(f"{program} is not installed")
    return found


def done(words: list[str], folder: Path, **environment: str) -> str:
    ran = subprocess.run(
        words, capture_output=True, text=True, check=False, cwd=folder, timeout=900,
        env={**os.environ, **environment},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    assert ran.stderr == ""
    return ran.stdout


def defines(name: str) -> list[str]:
    return [f"-DNAME={identifier(name)}", *(["-DPAIR"] if is_pair(name) else [])]


def in_c(name: str, text: str, folder: Path) -> list[str]:
    (folder / "stepper.c").write_text(text, encoding="utf-8")
    command = [need("gcc"), "-std=c99", "-O1", *STRICT, *SAFE, *defines(name)]
    done([*command, "-o", "run", "stepper.c", str(HERE / "kepler.c"), "-lm"], folder)
    return ["./run"]


def in_cpp(name: str, text: str, folder: Path) -> list[str]:
    (folder / "stepper.hpp").write_text(text, encoding="utf-8")
    command = [need("g++"), "-std=c++11", "-O0", *STRICT, *SAFE, *defines(name)]
    command += ['-DFILE_="stepper.hpp"', f"-I{folder}"]
    done([*command, "-o", "run", str(HERE / "kepler.cpp")], folder)
    return ["./run"]


def in_rust(name: str, text: str, folder: Path) -> list[str]:
    (folder / "stepper.rs").write_text(text, encoding="utf-8")
    shutil.copy(HERE / "kepler.rs", folder / "main.rs")
    chosen = ["--cfg", "pair"] if is_pair(name) else []
    allowed = ["--edition", "2021", "-O", "-D", "warnings", "--check-cfg", "cfg(pair)"]
    done([need("rustc"), *allowed, *chosen, "-o", "run", "main.rs"], folder)
    return ["./run"]


def in_fortran(name: str, text: str, folder: Path) -> list[str]:
    (folder / "stepper.f90").write_text(text, encoding="utf-8")
    command = [need("gfortran"), "-std=f2008", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror"]
    command += ["-fcheck=all", *defines(name), "-o", "run", "stepper.f90"]
    done([*command, str(HERE / "kepler.F90")], folder)
    return ["./run"]


def in_python(name: str, text: str, folder: Path) -> list[str]:
    (folder / "stepper.py").write_text(text, encoding="utf-8")
    shutil.copy(HERE / "kepler.py", folder / "main.py")
    return [sys.executable, "-W", "error", "main.py"]


def in_jax(name: str, text: str, folder: Path) -> list[str]:
    pytest.importorskip("jax", reason="jax is not installed")
    (folder / "stepper.py").write_text(text, encoding="utf-8")
    shutil.copy(HERE / "kepler.py", folder / "main.py")
    return [sys.executable, "main.py"]


def in_julia(name: str, text: str, folder: Path) -> list[str]:
    julia = shutil.which("julia")
    if julia is None:
        pytest.skip(
            "julia is not installed (no package of apt or pip has it); its files are parsed"
        )
    (folder / "stepper.jl").write_text(text, encoding="utf-8")
    shutil.copy(HERE / "kepler.jl", folder / "main.jl")
    return [julia, "--startup-file=no", "main.jl"]


BUILD = {
    "c": in_c,
    "c++": in_cpp,
    "rust": in_rust,
    "fortran": in_fortran,
    "python": in_python,
    "jax": in_jax,
    "julia": in_julia,
}
#: One case for each language that is quick; the others are slow.
QUICK = {("c", "gauss-2"), ("c", "pair-rkn-6-8b"), *((x, "rk4") for x in BUILD if x != "jax")}


def run(
    language: str, name: str, text: str, folder: Path, *, h: float = H, steps: int = STEPS
) -> list[float]:
    words = BUILD[language](name, text, folder)
    words += [str(h), str(steps)]
    if language == "julia":
        words.append("".join(x.capitalize() for x in identifier(name).split("_")))
    if language in ("python", "jax", "julia") and is_pair(name):
        words.append("pair")
    out = done(words, folder, JAX_ENABLE_X64="1", JAX_PLATFORMS="cpu")
    return [float(x) for x in out.split()]


def difference(y: list[float], z: list[float]) -> float:
    assert len(y) == len(z) == 4
    return max(abs(a - b) for a, b in zip(y, z, strict=True))


CASES = [
    pytest.param(
        language, name,
        marks=[] if (language, name) in QUICK else pytest.mark.slow, id=f"{language}-{name}",
    )
    for language in BUILD
    for name in METHODS
]  # fmt: skip


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("language", "name"), CASES)
def test_the_stepper_ends_where_the_engine_ends(language: str, name: str, tmp_path: Path) -> None:
    found = run(language, name, export(name, to=language), tmp_path)
    assert difference(found, end_of(name)) < TOLERANCE


@pytest.mark.parametrize("name", METHODS)
def test_a_julia_file_parses_and_has_the_numbers_of_the_python_file(name: str) -> None:
    """Where Julia is missing: its own grammar finds no error, and the tables are those that ran."""
    tree_sitter = pytest.importorskip("tree_sitter", reason="tree-sitter is not installed")
    julia = pytest.importorskip("tree_sitter_julia", reason="tree-sitter-julia is not installed")
    parser = tree_sitter.Parser(tree_sitter.Language(julia.language()))

    def numbers(text: str) -> list[float]:
        tree, found = parser.parse(text.encode()), []
        assert not tree.root_node.has_error, tree.root_node
        waiting = [tree.root_node]
        while waiting:
            node = waiting.pop()
            waiting += reversed(node.children)
            listed = node.type in ("vector_expression", "matrix_expression")
            if listed and node.parent.type != "index_expression":
                written = text.encode()[node.start_byte : node.end_byte].decode()
                entries = re.fullmatch(r"\[([-+0-9.e,\s]*)\]", written)
                found += [float(x) for x in entries[1].split(",")] if entries else []
        return found

    python: dict = {}
    exec(export(name, to="python"), python)
    tables = [python[key] for key in ("STEP", "START", "FINISH") if key in python]
    expected = [x for table in tables for key in table for x in flattened(table[key])]
    nonzero = [x for x in expected if x]
    found = [x for x in numbers(export(name, to="julia")) if x]
    assert found[: len(nonzero)] == nonzero != []
    broken = export(name, to="julia").replace("for turn in", "for for turn in", 1)
    assert parser.parse(broken.replace("return", "return )", 1).encode()).root_node.has_error


def flattened(value: object) -> list[float]:
    if isinstance(value, list | tuple):
        return [y for x in value for y in flattened(x)]
    return [float(value)]  # type: ignore[arg-type]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("language", "name"),
    [
        pytest.param(language, name, marks=[] if language == "python" else pytest.mark.slow)
        for language in BUILD
        for name in ("g4123", "pair-4-4")  # with a finishing method; two values of q and of p
    ],
)
def test_the_stepper_renews_its_values_as_the_engine_does(language, name, tmp_path):
    text, often = re.subn(r"(?<=renew)((: u64)? = )10000", r"\g<1>30", export(name, to=language),
                          flags=re.IGNORECASE)  # fmt: skip
    assert often == 1
    found = run(language, name, text, tmp_path, h=0.1, steps=200)
    problem = glmref.problem("kepler", eccentricity="1/5")
    never, renewed = (
        [float(x) for x in glmref.solve(problem, name, h=0.1, steps=200, renew=n).y[-1]]
        for n in (0, 30)
    )
    assert difference(found, renewed) < TOLERANCE < difference(never, renewed) / 10


def test_a_wrong_digit_in_a_coefficient_is_seen(tmp_path: Path) -> None:
    text = export("rk4", to="python")
    assert "0.3333333333333333" in text
    wrong = text.replace("0.3333333333333333", "0.3333333334333333", 1)
    assert difference(run("python", "rk4", wrong, tmp_path), end_of("rk4")) > TOLERANCE


def test_fewer_digits_are_another_method_and_the_comment_says_by_how_much(tmp_path: Path) -> None:
    text = export("gauss-2", to="python", digits=6)
    assert re.search(r"differ from the exact ones by at most [1-9.]+e-0[67]", text)
    found = difference(run("python", "gauss-2", text, tmp_path), end_of("gauss-2"))
    assert TOLERANCE < found < 1e-3


def force(q):
    r = (q[0] * q[0] + q[1] * q[1]) ** 0.5
    return [-q[0] / (r * r * r), -q[1] / (r * r * r)]


@pytest.mark.sampled(0)
@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [x for x in glmref.names("methods") if shipped(x)["class"] not in ("additive", "rosenbrock")],
)
def test_the_python_stepper_of_every_method_agrees_with_the_engine(name: str) -> None:
    """20 steps: 20 * 4 u * 1.6 is 1.4e-14; ten times that for starts with weights of that size."""
    if not getattr(glmref.load(name), "is_real", True):
        pytest.skip("complex methods are refused")
    stepper: dict = {}
    exec(export(name, to="python"), stepper)
    root = 1.5**0.5
    if is_pair(name):
        q, p = stepper["integrate"](lambda p: p, force, H, 20, [0.8, 0.0], [0.0, root])
        found = [*q, *p]
    else:
        f = lambda t, y: [y[2], y[3], *force(y)]  # noqa: E731
        found = stepper["integrate"](f, 0.0, H, 20, [0.8, 0.0, 0.0, root])
    problem = glmref.problem("kepler", eccentricity="1/5")
    expected = glmref.solve(problem, name, h=H, steps=20).y[-1]
    assert difference(found, [float(x) for x in expected]) < 1.4e-13


STIFF = """
import importlib, math, sys
stepper = importlib.import_module("stepper")
def f(t, y):
    return [-1e6 * (y[0] - math.cos(t)) - math.sin(t), y[0] - y[1] ** 3 + math.sin(t) * y[1]]
y = stepper.integrate(f, 0.3, 0.01, 300, [1.0, 0.5])
sys.stdout.write(" ".join(map(repr, y)))
"""


@pytest.mark.parametrize("name", ["tr-bdf2", "radau-iia-2", "bdf-3"])
def test_newton_takes_over_where_the_fixed_point_does_not_contract(name, tmp_path):
    """Prothero and Robinson's equation with lambda = -1e6, coupled to a cubic one."""
    import math

    import numpy as np

    def f(t, y):
        return np.array(
            [-1e6 * (y[0] - math.cos(t)) - math.sin(t), y[0] - y[1] ** 3 + math.sin(t) * y[1]]
        )

    (tmp_path / "stepper.py").write_text(export(name, to="python"), encoding="utf-8")
    (tmp_path / "main.py").write_text(STIFF, encoding="utf-8")
    found = [float(x) for x in done([sys.executable, "main.py"], tmp_path).split()]
    problem = glmref.Problem(name="stiff", source="", f=f, y0=(1.0, 0.5), t_span=(0.3, 3.3))
    ran = glmref.solve(problem, name, h=0.01, steps=300, solver="newton", engine="interpreted")
    # errors are damped here, so that only those of the last steps remain
    assert max(abs(a - b) for a, b in zip(found, ran.y[-1], strict=True)) < 1e-13


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize(
    "name",
    ["rk4", pytest.param("g4123", marks=pytest.mark.slow),
     pytest.param("thesis-3-8", marks=pytest.mark.slow)],
)  # fmt: skip
def test_an_exported_stepper_passes_the_conformance_suite(name: str, tmp_path: Path) -> None:
    method, scheme = glmref.load(name), scheme_of(glmref.load(name))
    (tmp_path / "stepper.c").write_text(export(method, to="c"), encoding="utf-8")
    offers = ['"step"', *(['"start"'] if scheme.start is not None else [])]
    offers += ['"finish"'] if scheme.finish is not None else []
    words = [need("gcc"), "-std=c99", "-O1", *STRICT, f"-DNAME={identifier(name)}"]
    words += [f'-DTITLE="{name}"', f"-DROWS={scheme.r}"]
    words += ["-DOFFERS=" + '"' + ", ".join(offers).replace('"', '\\"') + '"']
    words += ["-DIMPLICIT"] if scheme.implicit else []
    done([*words, "-o", "run", "stepper.c", str(HERE / "adapter.c"), "-lm"], tmp_path)
    ran = subprocess.run(
        [sys.executable, "-m", "glmref.conformance", "cmd:./run"],
        capture_output=True, text=True, check=False, cwd=tmp_path, timeout=300,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert re.search(rf"{name}: (\d+) of \1 hold", ran.stdout), ran.stdout
