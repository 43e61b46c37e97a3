"""Files of records with faults: what comes back is what was measured, or nothing.

A file of sound records is hit by flipped bits, cut, doubled and foreign lines and mutated JSON. The
readers of runs and of reports take it or refuse it with a sentence; a record that is returned is
one of those that were written, number by number.
"""

import json
import random
import tempfile
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any

from glmref.compute import Records
from glmref.compute.records import CHECKSUM, lines_of, made
from glmref.errors import DataError, GlmrefError
from glmref.report.store import read as read_report

from .texts import mutated

CASES = "record files"
COUNT = 2000
SECONDS = 3.0


@lru_cache
def sound() -> tuple[dict[str, Any], ...]:
    """Records as a run writes them."""
    tasks = [{"scene": "x", "method": m, "h": h} for m in ("rk4", "gauss-2") for h in (0.1, 0.05)]
    return tuple(
        made(task, {"error": 1e-3 / (k + 1), "outcome": "completed", "rows": [[k, 0.5]]})
        for k, task in enumerate(tasks)
    )


def _hit(draw: random.Random, content: bytes) -> bytes:
    lines = content.split(b"\n")
    how, k = draw.randrange(9), draw.randrange(len(lines))
    if how == 0:
        changed = bytearray(content)
        for _ in range(draw.choice((1, 1, 5, 50))):
            changed[draw.randrange(len(changed))] ^= 1 << draw.randrange(8)
        return bytes(changed)
    if how == 1:
        return content[: draw.randrange(len(content))]
    if how == 2:
        lines.insert(k, lines[draw.randrange(len(lines))])
    elif how == 3:
        lines[k] = mutated(draw, draw.choice(sound()), text=0.3).replace(b"\n", b" ")
    elif how == 4:
        deep = draw.choice((50, 100_000))
        extra = (b"null", b"[]", b"{}", b"x", b"\x00" * 9, b"[" * deep, b'{"format":' * deep,
                 b"9" * 5000, b'{"format":"glmref-record-1"}', b"\xff\xfe", b"x" * 10**6)  # fmt: skip
        lines.insert(k, draw.choice(extra))
    elif how == 5:
        lines[k] += lines[draw.randrange(len(lines))]
    elif how == 6:
        return content.replace(b"\n", draw.choice((b"\r\n", b"\r", b" ", b"\x85")))
    elif how == 7:
        at = draw.randrange(len(content))
        return content[:at] + content[draw.randrange(len(content)) :]
    else:
        return draw.choice(
            (b"", b"\n" * 10, b"\xef\xbb\xbf" + content, content.decode("latin-1").encode("utf-16"))
        )
    return b"\n".join(lines)


def judge(draw: random.Random) -> tuple[str, Iterable[str]]:
    """Damage a file of records, as it is kept or in lines, and read it in both ways."""
    lines = [json.dumps(x, separators=(",", ":")).encode() for x in sound()]
    content, kept = b"".join(line + b"\n" for line in lines), draw.random() < 0.5
    written = [json.dumps(x, sort_keys=True) for x in sound()]
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / ("x.sqlite" if kept else "x.jsonl")
        if kept:
            store = Records(path)
            store.append_all((x["task"], _measured(x)) for x in sound())
            store.close()
            content = path.read_bytes()
        for _ in range(draw.choice((1, 1, 2, 4))):
            content = _hit(draw, content) if content else content
        path.write_bytes(content)
        report = read_report([path], ["rk4", "gauss-2"])
        try:
            run = Records(path.with_suffix(".sqlite"))
            found = list(run)
        except DataError:
            run, found = None, []
        for where, records in (("a run", found), ("the report", list(report.records))):
            # records of version 0.1.0 have no checksum, so that a change of them is not seen
            texts = [json.dumps(x, sort_keys=True) for x in records if CHECKSUM in x]
            wrong += [
                f"{where} reads what nobody wrote: {x[:200]}" for x in texts if x not in written
            ]
            if len(set(texts)) < len(texts):
                wrong.append(f"{where} reads a record twice")
        if not kept:
            strange = [x for x in map(bytes.strip, content.splitlines()) if x and x not in lines]
            read = [(record, why) for _, record, why in lines_of(path)]
            summed = all(record is None or CHECKSUM in record for record, _ in read)
            if strange and summed and not any(why for _, why in read):
                wrong.append(f"a change is not seen: {strange[0][:200]!r}")
        elif run is not None:
            try:
                run.append_all((x["task"], _measured(x)) for x in sound())
                if sorted(json.dumps(x, sort_keys=True) for x in run) != sorted(written):
                    wrong.append("what was lost is not there after it was written again")
            except GlmrefError as error:
                known = "cannot be written", "is damaged ("
                wrong += [] if any(x in str(error) for x in known) else [str(error)]
    end = f"{len(found)} of {len(written)} records"
    return end, wrong


def _measured(record: dict[str, Any]) -> dict[str, Any]:
    return {k: x for k, x in record.items() if k not in ("format", "key", "task", CHECKSUM)}
