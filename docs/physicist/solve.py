"""Solve the double pendulum with one method, draw its path and print where it ends."""

import sys

import glmref

run = glmref.solve("double-pendulum.toml", sys.argv[1], h=0.05, t_end=10, every=1)
run.plot("orbit", components=["q1", "q2"]).save("path.svg")
run.save("run.npz")
sys.stdout.write(" ".join(f"{x:.12f}" for x in run.y[-1]) + "\n")
