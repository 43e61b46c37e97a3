"""Steps of compiled kernels, of the reference, in lanes; generating and compiling; against C."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from glmref import solve
from glmref.catalogue.lookup import load
from glmref.engine.codegen import ARGUMENTS, kernel_source
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.kernel import prepare
from glmref.engine.native import compile_kernel
from glmref.engine.options import Options
from glmref.engine.reference import stepper
from glmref.engine.shape import shape_of
from glmref.engine.starting_values import starting_values, zero_start
from glmref.engine.sweep import step_form
from glmref.problems import problem
from tools.measure import compare_c, compare_textbook

METHODS = ["rk4", "gauss-3", "s4-symmetric", "g6245", "stormer-verlet", "kahan-li-8"]
PROBLEMS = {"kepler": 0.02, "henon-heiles": 0.1, "outer-solar-system": 50.0}


class Steps:
    """A thousand steps of one trajectory."""

    params = [METHODS, list(PROBLEMS)]
    param_names = ["method", "problem"]
    version = "1"

    def setup(self, method, name):
        self.h, of, chosen = PROBLEMS[name], problem(name), load(method)
        self.kernel = prepare(chosen, of, h=self.h)
        self.values = zero_start(stepper(chosen, of), of.y0)
        self.slope = np.asarray(of.f(0.0, of.y0))
        self.grid = {"t0": 0.0, "h": self.h, "every": 0, "out": np.empty((1, 1, of.dimension))}

    def time_thousand(self, method, name):
        self.kernel.advance(self.kernel.state(self.values, self.slope, self.h), 1000, **self.grid)

    def track_evaluations(self, method, name):
        state = self.kernel.state(self.values, self.slope, self.h)
        self.kernel.advance(state, 1000, **self.grid)
        return float(state.tally[0]) / 1000

    track_evaluations.unit = "evaluations per step"


class Reference:
    """One step as one reads it in a paper."""

    params = [["rk4", "gauss-3", "g6245"], ["kepler", "outer-solar-system"]]
    param_names = ["method", "problem"]

    def setup(self, method, name):
        self.h, of = PROBLEMS[name], problem(name)
        self.stepper = stepper(load(method), of)
        self.values = zero_start(self.stepper, of.y0)

    def time_step(self, method, name):
        self.stepper.step(0.0, self.values, self.h)


class Ensemble:
    """A hundred steps of 1024 trajectories in one thread."""

    params = [["rk4", "gauss-3", "g6245", "stormer-verlet"], ["kepler", "henon-heiles"]]
    param_names = ["method", "problem"]

    def setup(self, method, name):
        of = problem(name)
        self.initial = np.repeat(np.array([of.y0]), 1024, axis=0)
        self.options = {"h": PROBLEMS[name], "steps": 100, "start": "zero", "threads": 1}
        self.of, self.method = of, load(method)

    def time_lanes(self, method, name):
        solve_ensemble(self.of, self.method, self.initial, **self.options)


class Build:
    """What the first run of a method on a problem costs before its first step."""

    params = [["rk4", "gauss-3", "g6245"], ["kepler", "outer-solar-system"]]
    param_names = ["method", "problem"]
    timeout = 120

    def setup(self, method, name):
        self.method: Any = load(method)
        self.form, self.shape = step_form(self.method), shape_of(problem(name))
        self.text = kernel_source(self.form, self.shape, Options()).text

    def time_form(self, method, name):
        step_form(self.method)

    def time_source(self, method, name):
        kernel_source(self.form, self.shape, Options())

    def time_compile(self, method, name):
        compile_kernel(self.text, ARGUMENTS, None)


class Start:
    """Starting values: from the method's data, and by iteration."""

    params = [[None, "enhanced"]]
    param_names = ["start"]

    def setup(self, start):
        of = problem("kepler")
        self.stepper, self.y0 = stepper(load("g6245"), of), np.array(of.y0)

    def time_values(self, start):
        starting_values(self.stepper, start, t=0.0, y0=self.y0, h=0.02)


class Against:
    """Times of a loop in C beside those of the engine."""

    param_names = ["method", "problem"]
    timeout = 120

    def setup(self, method, name):
        if compare_c.compiler() is None:
            raise NotImplementedError
        with tempfile.TemporaryDirectory() as folder:
            self.row = self.measured(method, name, Path(folder))


class AgainstC(Against):
    """Time of a hand-written C loop of the same arithmetic over the engine's: 1 is a draw."""

    params = [list(compare_c.METHODS), list(compare_c.PROBLEMS)]

    def measured(self, method, name, folder):
        return compare_c.measure(method, name, folder, repeats=5, seconds=0.01)

    def track_c_over_engine(self, method, name):
        return float(self.row.c_over_engine[1])

    def track_reference_over_engine(self, method, name):
        return float(self.row.reference_over_engine)

    track_c_over_engine.unit = track_reference_over_engine.unit = "ratio"


class AgainstTextbook(Against):
    """Plain C from the formulas, by someone who had not read the engine; both compensate."""

    params = [list(compare_textbook.METHODS), list(compare_textbook.STEPS)]

    def measured(self, method, name, folder):
        return compare_textbook.measured(method, name, folder, repeats=3)

    def track_c_over_engine(self, method, name):
        return self.row.ratio

    def track_fused_c_over_fused_engine(self, method, name):
        return self.row.fused_ratio

    track_c_over_engine.unit = track_fused_c_over_fused_engine.unit = "ratio"


class Quick:
    """Evaluations of ``arithmetic="quick"`` over those of ``"strict"``."""

    params = [["gauss-3", "g6245"], list(PROBLEMS)]
    param_names = ["method", "problem"]

    def track_evaluations(self, method, name):
        counts = []
        for arithmetic in ("strict", "quick"):
            options = {"h": PROBLEMS[name], "steps": 1000, "solver": "fixed-point"}
            counts.append(solve(name, method, arithmetic=arithmetic, **options).evaluations)
        return counts[1] / counts[0]

    track_evaluations.unit = "ratio"
