"""Mutated files of campaigns and of own problems: read and used, or refused with a sentence."""

import json
import random
import tempfile
import tomllib
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from glmref import problem
from glmref.catalogue.files import data_root
from glmref.scenes.campaign import load_campaign

from .scenes import MUTATIONS, change, toml
from .texts import mutated

CASES = "campaigns and problems"
COUNT = 2000
SECONDS = 5.0
PROBLEMS = (
    'H = "p**2/2 - cos(q)"\ny0 = { q = "5/2", p = 0 }\nt_end = "20*pi"\n[parameters]\na = "1/3"\n',
    'f = { x = "v", v = "-k*sin(x)" }\ny0 = { x = 1, v = 0 }\nt_end = 10\nparameters = { k = 2 }\n',
    'f = ["y[1]", "-y[0]"]\ny0 = [1, 0]\nname = "mine"\nsource = "x"\n',
    """
H = "sum(p[i]**2/(2*m[i]) for i in range(n)) + sum(q[i]**2 for i in range(n))"
y0 = { q = [1, 2], p = [0, 0] }
parameters = { m = [1, 2] }
""",
    'file = "mine.py:make"\nt_end = 3\n',
)


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Read one mutated file, and use it."""
    own = draw.random() < 0.5
    shipped = sorted((data_root() / "campaigns").glob("*.toml"))
    text = draw.choice(PROBLEMS) if own else draw.choice(shipped).read_text(encoding="utf-8")
    how = draw.random()
    if how < 0.3:
        text = change(draw, text)
    elif how < 0.75:
        document = json.loads(mutated(draw, tomllib.loads(text), text=0.0))
        text = toml(document if isinstance(document, dict) else {"x": document})
    else:
        for _ in range(draw.choice((1, 1, 2, 4))):
            text = draw.choice(MUTATIONS)(draw, text or "x")
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "x.toml"
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
        if not own:
            campaign = load_campaign(str(path))
            tasks = campaign.spread(2) if len(campaign) < 10**5 else []
            return "planned", [f"{x!r} is no task" for x in tasks if not isinstance(x, dict)]
        made = problem(str(path))
        with np.errstate(all="ignore"):
            try:
                found = np.asarray(made.f(0.25, np.asarray(made.y0, dtype=float)), dtype=float)
            except ArithmeticError:  # as Python says that there is no value
                return "no value", ()
        return "problem", [] if found.shape == (made.dimension,) else [f"f: {found.shape}"]
