"""Error, evaluations and run time over the same parameters, so that they pair up."""

import math

import numpy as np

from glmref.catalogue.lookup import load
from glmref.engine.kernel import prepare
from glmref.engine.reference import stepper
from glmref.engine.starting_values import zero_start
from glmref.measure.work_precision import measure
from glmref.problems import problem


class WorkPrecision:
    """Method x problem x steps to t = 20, or over one period."""

    params = [
        ["gauss-2", "gauss-3", "gsymplectic-n", "s4-symmetric", "g6245"],
        ["harmonic-oscillator", "pendulum", "kepler"],
        [500, 2000],
    ]
    param_names = ["method", "problem", "steps"]
    version = "1"
    timeout = 120

    def setup(self, method, name, steps):
        subject, chosen = problem(name), load(method)
        h = subject.scales.get("period", 20.0) / steps
        self.work = measure(subject, chosen, h=h, steps=steps, repeats=1, start="zero")
        if not self.work.completed:
            raise NotImplementedError
        self.kernel = prepare(chosen, subject, h=h)
        values = zero_start(stepper(chosen, subject), subject.y0)
        self.begin = (values, np.asarray(subject.f(0.0, subject.y0)), h)
        self.grid = {"t0": 0.0, "h": h, "every": 0, "out": np.empty((1, 1, subject.dimension))}

    def time_run(self, method, name, steps):
        self.kernel.advance(self.kernel.state(*self.begin), steps, **self.grid)

    def track_error(self, method, name, steps):
        return finite(self.work.state_error)

    def track_energy_error(self, method, name, steps):
        return finite(self.work.energy_error)

    def track_evaluations(self, method, name, steps):
        return finite(self.work.evaluations)

    track_error.unit = track_energy_error.unit = "relative"
    track_evaluations.unit = "evaluations"


def finite(value):
    """Return a float that asv can store: an infinity would stop it from publishing for good."""
    if value is None or not math.isfinite(value):
        raise NotImplementedError
    return float(value)
