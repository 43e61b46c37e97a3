"""Solve the double pendulum with one method, draw its path and print where it ends."""

import sys
from pathlib import Path

import glmref

run = glmref.solve("double-pendulum.toml", sys.argv[1], h=0.05, t_end=10, every=1)
points = " ".join(f"{200 + 60 * q1:.2f},{200 - 60 * q2:.2f}" for q1, q2, *_ in run.y)
line = f'<polyline points="{points}" fill="none" stroke="black"/>'
picture = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 400">{line}</svg>'
Path("path.svg").write_text(picture)
sys.stdout.write(" ".join(f"{x:.12f}" for x in run.y[-1]) + "\n")
