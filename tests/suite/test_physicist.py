"""The physicist's way on docs/physicist.md: from H alone to a C file that reproduces the run."""

import json
import re
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from glmref.problems import problem
from glmref.views.problem_page import c_source

PAGE = Path(__file__).parents[2] / "docs" / "physicist.md"


def commands():
    blocks = re.findall(
        r"^```console\n(.*?)^```$", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE
    )
    return [line[2:] for block in blocks for line in block.splitlines() if line.startswith("$ ")]


def carry_out(command, folder, python):
    program, _, rest = command.partition(" ")
    starts = {"glmref": f"{python} -m glmref", "python": python}
    words = f"{starts.get(program, program)} {rest}"
    done = subprocess.run(
        ["sh", "-c", words], cwd=folder, capture_output=True, text=True, check=False, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_five_commands_lead_from_h_to_a_c_file_that_reproduces_the_run(tmp_path):
    text = PAGE.read_text("utf-8")
    table = re.search(r"^```toml\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    (tmp_path / "double-pendulum.toml").write_text(table[1])
    for path in (PAGE.parent / "physicist").iterdir():
        shutil.copy(path, tmp_path)
    asked, python = commands(), shlex.quote(sys.executable)
    assert len(asked) == 5
    begin = time.process_time(), time.perf_counter()
    carry_out(asked[0], tmp_path, python)
    found = json.loads((tmp_path / "out" / "double-pendulum.json").read_text())
    take = found["recommended"]
    (runs,) = (x["long_runs"] for x in found["candidates"] if x["method"] == take)
    assert runs not in ("lost", "grows")  # what is lost may be the fastest
    outputs = [
        carry_out(line.replace("gauss-4", take).replace("gauss_4", take.replace("-", "_")),
                  tmp_path, python)
        for line in asked[1:]
    ]  # fmt: skip
    assert time.perf_counter() - begin[1] < 60
    ours, theirs = (np.array(outputs[k].split(), dtype=float) for k in (0, -1))
    np.testing.assert_allclose(theirs, ours, rtol=0, atol=1e-11)
    exact = problem("double-pendulum")
    assert abs(exact.hamiltonian(theirs) - exact.hamiltonian(exact.y0)) < 1e-7
    assert (tmp_path / "path.svg").read_text().startswith("<svg")


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
@pytest.mark.parametrize("name", ["double-pendulum", "kepler", "oregonator", "lotka-volterra"])
def test_the_right_hand_side_in_c_is_that_of_the_problem(name, tmp_path):
    subject = problem(name)
    main = (
        "int main(void) { double out[dimension]; rhs(0.5, initial, out, 0);"
        ' for (int i = 0; i < dimension; i++) printf("%.17g\\n", out[i]); return 0; }\n'
    )
    if subject.separable:
        main = main.replace("rhs(0.5", "(void)dq; (void)dp; rhs(0.5")
    (tmp_path / "main.c").write_text("#include <stdio.h>\n" + c_source(subject) + main)
    build = ["cc", "-Wall", "-Werror", "-ffp-contract=off", "main.c", "-lm", "-o", "run"]
    subprocess.run(build, cwd=tmp_path, check=True)
    done = subprocess.run([str(tmp_path / "run")], capture_output=True, text=True, check=True)
    expected = subject.f(0.5, subject.y0)
    np.testing.assert_allclose(
        [float(x) for x in done.stdout.split()], expected, rtol=1e-14, atol=1e-300
    )
