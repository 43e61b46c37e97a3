#!/usr/bin/env python3
"""Prove the catalogue in Coq: compile the library, write one file for each method, compile them.

    python checker/coq/check.py [NAME...] [--jobs 2] [--folder checker/coq/build]

Every theorem must print "Closed under the global context": no axiom is used. Exit code 0 when all
methods are proved, 1 when one is not, 3 with a message where Coq is not installed. Python standard
library only; `python -m glmref.prove.coq` writes the files, and Coq trusts nothing of it.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TextIO

HERE = Path(__file__).resolve().parent

#: In order of compilation: each needs those before it.
LIBRARY = ("Trees", "Field", "GLM", "Symplectic", "NotOrder", "Printed", "Explicit", "Reals")

#: The exact methods that are proved when none is named.
METHODS = """
    euler gauss-1 midpoint-explicit heun-2 ralston-2 trapezoidal qin-zhang-2 sdirk-2 tr-bdf2
    kutta-3 heun-3 ralston-3 ssp-rk3 bogacki-shampine-3 sdirk-3 rk4 rk38 gill-4 ralston-4 merson-4
    rkf45-4 rkf45-5 cash-karp-5 dormand-prince-4 dormand-prince-5 nystrom-5 butcher-6 luther-6
    rkf78-8 cooper-verner-8 dormand-prince-8-5-3 gauss-2 gauss-3 gauss-4 gauss-5 radau-ia-3
    radau-iia-2 radau-iia-3
    lobatto-iiia-3 lobatto-iiia-4 lobatto-iiib-3 lobatto-iiib-4 lobatto-iiic-3 lobatto-iiic-4
    yoshida-4 suzuki-4 gsymplectic-n gsymplectic-p thesis-3-8 s4-symmetric g4123 g6245 g6245-w3
    c2-3-10-w3 ark-4 pseudo-rk-4 dimsim-2-type-2 abm-4-pece ab-4 am-4 bdf-6 milne-simpson hamming
    leapfrog milne-simpson-one-leg stormer-verlet symplectic-euler-a ruth-3 mclachlan-4
    forest-ruth-4 suzuki-verlet-4 lobatto-iiia-iiib-3 lobatto-iiia-iiib-4 gsymplectic-n-pair
    thesis-order6-printed-a
""".split()


def say(text: str, stream: TextIO = sys.stdout) -> None:
    """Write a line at once."""
    stream.write(f"{text}\n")
    stream.flush()


def coqc(folder: Path, file: Path) -> tuple[bool, str, float]:
    """Compile one file; return whether it went through, what was printed, and processor seconds."""
    with file.with_suffix(".out").open("w+", encoding="utf-8") as out:
        command = ["coqc", "-Q", str(folder), "Glmref", str(file)]
        run = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        return run.returncode == 0, out.read(), usage.ru_utime + usage.ru_stime


def closed(text: str, printed: str) -> str:
    """Say what is wrong with the axioms of a compiled file, or nothing."""
    theorems = re.findall(r"^Theorem (\w+)", text, re.M)
    asked = re.findall(r"^Print Assumptions (\w+)\.", text, re.M)
    if set(theorems) != set(asked):
        return "a theorem is not followed by Print Assumptions"
    if re.search(r"\b(Axiom|Admitted|Parameter|Hypothesis|Conjecture)\b", text):
        return "the file assumes something"
    if printed.count("Closed under the global context") != len(theorems) or not theorems:
        return "a theorem depends on an axiom"
    return ""


def library(folder: Path) -> str:
    """Compile the library into the folder; return what went wrong, or nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in LIBRARY:
        source, file = HERE / f"{name}.v", folder / f"{name}.v"
        compiled = folder / f"{name}.vo"
        text = source.read_text(encoding="utf-8")
        if compiled.exists() and file.exists() and file.read_text(encoding="utf-8") == text:
            continue
        for later in LIBRARY[LIBRARY.index(name) :]:
            (folder / f"{later}.vo").unlink(missing_ok=True)
        file.write_text(text, encoding="utf-8")
        good, printed, seconds = coqc(folder, file)
        if not good or set(printed.splitlines()) - {"Closed under the global context"}:
            compiled.unlink(missing_ok=True)
            return f"{name}.v: {printed.strip()}"
        say(f"{name + '.v':28} library             {seconds:6.1f} s")
    return ""


def prove(folder: Path, name: str) -> tuple[str, str, float]:
    """Compile the file of one method; return its theorems, what went wrong, and seconds."""
    file = folder / ("m_" + "".join(x if x.isalnum() else "_" for x in name) + ".v")
    text = file.read_text(encoding="utf-8")
    good, printed, seconds = coqc(folder, file)
    wrong = closed(text, printed) if good else printed.strip().replace("\n", " ")[-300:]
    stem = file.stem + "_"
    found = [x.removeprefix(stem) for x in re.findall(r"^Theorem (\w+)", text, re.M)]
    return ", ".join(found), wrong, seconds


def main() -> int:
    """Prove what is named, or all of METHODS."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", default=METHODS)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=HERE / "build")
    options = parser.parse_args()
    if shutil.which("coqc") is None:
        say("coqc is missing: install the Debian package coq (8.16 or later)", sys.stderr)
        return 3
    began = time.perf_counter()
    wrong = library(options.folder)
    if wrong:
        say(wrong, sys.stderr)
        return 1
    write = [sys.executable, "-m", "glmref.prove.coq", *options.names]
    if subprocess.run([*write, "--output", str(options.folder)], check=False).returncode:
        return 1
    failed = total = 0
    spent = 0.0
    with ThreadPoolExecutor(options.jobs) as pool:
        done = pool.map(lambda name: prove(options.folder, name), options.names)
        for name, (theorems, wrong, seconds) in zip(options.names, done, strict=True):
            failed += bool(wrong)
            total += len(theorems.split(", "))
            spent += seconds
            say(f"{name:28} {seconds:6.1f} s  {theorems}")
            if wrong:
                say(f"{name}: {wrong}", sys.stderr)
    say(
        f"{len(options.names) - failed} of {len(options.names)} methods, {total} theorems, "
        f"{spent:.0f} s of processor time, {time.perf_counter() - began:.0f} s in all"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
