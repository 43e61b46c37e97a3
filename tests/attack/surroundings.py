"""A command in hostile surroundings: variables, folders and kept verdicts that are not as expected.

``glmref verify`` must find what it finds elsewhere, or say in one sentence what it was given. An
entry of the kept verdicts is damaged before, and never changes what is found.
"""

import contextlib
import hashlib
import io
import os
import random
import tempfile
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from unittest.mock import patch

from glmref.cli import main as glmref
from glmref.prove import verdict_cache as kept
from glmref.system import cache

from .files import SENTENCE
from .texts import mutated

CASES = "surroundings"
COUNT = 1000
SECONDS = 10.0
NAMES = ("rk4", "ab-2", "yoshida-4-sign")
#: What a variable may say; ``{x}`` is a folder that can be written.
FOLDERS = (
    "{x}", "{x}/new/folder", "/dev/null", "/proc/self/mem", "/proc", "/", "", " ", ".", "~", "~nobody/x",
    "{x}/file", "{x}/file/below", "{x}/loop", "{x}/closed", "x" * 5000, "{x}/" + "y" * 300, "\n", "\x1b[2J",
    "relative/folder", "//", "{x}/fifo", "\udcff",
)  # fmt: skip
WORDS = (
    "", "here", "0", "1", "local", "local:", "local:0", "local:-1", "local:x", "local:1e9", "dask:", "dask:0",
    "dask:nothing.json", "remote", "HERE", " here", "x" * 9000, "here\n", "\x1b]0;x\x07", "local:9" + "9" * 5000,
    "local:\u0661", "local:\u00b2",
)  # fmt: skip
VARIABLES = {
    "GLMREF_CACHE": FOLDERS, "XDG_CACHE_HOME": FOLDERS, "HOME": FOLDERS, "TMPDIR": FOLDERS,
    "GLMREF_EXECUTOR": WORDS, "GLMREF_DEBUG": WORDS, "GLMREF_ADAPTER": WORDS, "NO_COLOR": WORDS,
    "COLUMNS": WORDS, "LINES": WORDS, "TERM": WORDS, "LANG": WORDS, "TZ": WORDS, "PAGER": WORDS,
}  # fmt: skip


def _surroundings(draw: random.Random, folder: Path) -> dict[str, str | None]:
    (folder / "file").write_text("x")
    (folder / "loop").symlink_to("loop")
    (folder / "closed").mkdir(0o500)
    os.mkfifo(folder / "fifo")
    found: dict[str, str | None] = {}
    for _ in range(draw.choice((1, 1, 2, 4))):
        name = draw.choice(list(VARIABLES))
        value = draw.choice(VARIABLES[name]).replace("{x}", str(folder))
        found[name] = None if draw.random() < 0.1 else value
    return found


def _ran(name: str, variables: dict[str, str | None]) -> tuple[int, str, str]:
    """Run ``glmref verify``: exit code, output, and what is said."""
    out, err = io.StringIO(), io.StringIO()
    with (patch.dict(os.environ), patch.object(tempfile, "tempdir", None),
          patch.object(kept, "private_folder", cache.private_folder),
          contextlib.redirect_stdout(out), contextlib.redirect_stderr(err)):  # fmt: skip
        for key, value in variables.items():
            os.environ.pop(key, None) if value is None else os.environ.update({key: value})
        code = glmref(["verify", name, "--format", "json"])
    return code, out.getvalue(), err.getvalue().strip()


@lru_cache
def right(name: str) -> tuple[int, str]:
    """Exit code and output without any of that."""
    with tempfile.TemporaryDirectory() as folder:
        code, out, _ = _ran(name, {"GLMREF_CACHE": folder, "GLMREF_EXECUTOR": None})
    return code, out


def prepare() -> None:
    """Read what all cases need."""
    for name in NAMES:
        right(name)


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Verify one method, in hostile surroundings or with a damaged entry."""
    name = draw.choice(NAMES)
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        try:
            if draw.random() < 0.5:
                variables, end = _damaged(draw, name, Path(place)), "damaged entry"
            else:
                variables, end = _surroundings(draw, Path(place)), "the same"
            code, out, err = _ran(name, variables)
        finally:
            os.chdir(before)
    if code == 2 and not out and err and "\n" not in err and len(err) <= SENTENCE:
        executor = variables.get("GLMREF_EXECUTOR")
        return "refused", [] if executor else [f"{variables} is refused: {err[:200]!r}"]
    if (code, out) != right(name) or err:
        return "other", [f"{variables}: exit code {code}, {out[:200]!r}, {err[:200]!r}"]
    return end, ()


def _damaged(draw: random.Random, name: str, folder: Path) -> dict[str, str | None]:
    """Keep a verdict, and damage its entry."""
    variables: dict[str, str | None] = {"GLMREF_CACHE": str(folder), "GLMREF_EXECUTOR": None}
    _ran(name, variables)
    (entry,) = (folder / "verdicts").iterdir()
    content = bytearray(entry.read_bytes())
    how = draw.randrange(4)
    if how == 0:
        for _ in range(draw.choice((1, 3, 50))):
            content[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
    elif how == 1:
        content = content[: draw.randrange(len(content))]
    elif how == 2:
        content += draw.choice((b"\n", b"x", b"{}", bytes(10_000_000)))
    else:  # with the checksum of what is nonsense
        text = mutated(draw, ["x", 1, {"asked": [], "read": {"/": 1}}], text=0.5)
        content = bytearray(hashlib.sha256(text).digest() + text)
    entry.write_bytes(content)
    return variables
