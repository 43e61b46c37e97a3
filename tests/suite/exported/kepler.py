"""Kepler's problem, e = 0.2, with the exported stepper that lies beside this file."""

import importlib
import math
import sys

stepper = importlib.import_module("stepper")
array = list
if hasattr(stepper, "jnp"):
    array = stepper.jnp.array


def force(q):
    r = (q[0] * q[0] + q[1] * q[1]) ** 0.5
    return array([-q[0] / (r * r * r), -q[1] / (r * r * r)])


def f(t, y):
    k = force(y)
    return array([y[2], y[3], k[0], k[1]])


h, steps, pair = float(sys.argv[1]), int(sys.argv[2]), len(sys.argv) > 3
if pair:
    q, p = stepper.integrate(lambda p: p, force, h, steps, [0.8, 0.0], [0.0, math.sqrt(1.5)])
    y = [*q, *p]
else:
    y = stepper.integrate(f, 0.0, h, steps, array([0.8, 0.0, 0.0, math.sqrt(1.5)]))
sys.stdout.write(" ".join(repr(float(x)) for x in y) + "\n")
