"""Audit: how much of a tree without tables is split into tokens, which is what takes its time."""

from __future__ import annotations

import sysconfig
from pathlib import Path

from glmref.audit.recognising import may_hold
from glmref.audit.sources import read_source


class Tokens:
    """Of the standard library of Python, in which no file holds a table."""

    timeout = 120

    def setup(self) -> None:
        library = Path(sysconfig.get_path("stdlib"))
        paths = [x for x in library.rglob("*.py") if "site-packages" not in x.parts]
        self.texts = [(x.name, read_source(x) or "") for x in paths]

    def track_files(self) -> float:
        return sum(may_hold(text, name) for name, text in self.texts) / len(self.texts)

    def track_characters(self) -> float:
        split = sum(len(text) for name, text in self.texts if may_hold(text, name))
        return split / sum(len(text) for _, text in self.texts)

    def time_may_hold(self) -> None:
        for name, text in self.texts:
            may_hold(text, name)
