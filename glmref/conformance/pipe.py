"""Adapters in any language: a program that speaks JSON lines on its stdin and stdout.

Each line is one JSON object. We ask, the program answers; while it works on a step it may ask for
the right-hand side as often as it likes::

    > {"ask": "describe"}
    < {"methods": ["thesis-3-8"], "offers": ["step", "stages", "start"], "tolerance": 1e-14}
    > {"ask": "step", "method": "thesis-3-8", "problem": "cubic", "separable": true,
       "t": 0.0, "h": 0.125, "rows": 3, "columns": 2, "values": [1.375, 0.625, ...]}
    < {"ask": "f", "t": 0.0, "y": [1.375, 0.625]}
    > {"values": [0.625, -1.224609375]}
    < {"values": [...]}

Arrays are flat, row by row; ``values`` of a step are the (r, d) values carried, and the keys of a
line come in the order shown. Questions to the program: ``describe``, ``step``, ``stages`` (answer:
``values``, flat; of a pair Q first, then P), ``start`` (``y0`` in place of ``values``), ``finish``,
``solve`` (``y0``, ``steps``, and ``start`` where starting values are given). Questions to us:
``f`` and ``jacobian`` (with ``t`` and ``y``), ``dq`` (with ``p``), ``dp`` (with ``q``). A program
that cannot do something answers ``{"error": "one sentence"}``; ``{"cannot": "..."}`` says that it
is not offered. It ends when its stdin does.

A program that breaks the protocol (it ends, is silent, or writes something else to its stdout) is
ended and started again for the next question, so that one failure does not spoil the checks after
it; after three silences it is not asked any more. A program is the leader of a process group of its
own, which ends with it: what it started does not run on. Each of its lines, what it writes to its
stderr, the time of one answer and the questions it may ask meanwhile have a limit.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import selectors
import shlex
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from typing import Any
from uuid import uuid4

import numpy as np

from ..catalogue.strict_json import unique
from ..errors import DataError, GlmrefError, UsageError
from ..system.files import reason
from ..system.process import MARK, end_group, ending, remember_group
from ..system.terminal import escaped
from .subject import OPERATIONS

#: Seconds a program may be silent.
PATIENCE = 60.0
#: Seconds a program may take for one answer, its own questions included.
LONGEST = 600.0
#: Bytes of one line: some ten times the longest answer of the suite.
MAX_LINE = 16_000_000
#: Bytes of a program's stderr that are shown; the rest is read and dropped.
MAX_STDERR = 64_000
#: Silences after which a program is given up.
_SILENCES = 3
#: Seconds between two looks at whether a program is still there.
_LOOK = 0.2


class PipeError(GlmrefError):
    """What a program answered, or that it did not."""


class NotOffered(NotImplementedError):
    """What the program says it cannot do."""


class BrokenPipe(PipeError):
    """The program broke the protocol: its next line could belong to any question."""


class PipeAdapter:
    """A program as an adapter: the program and its arguments as in a shell, and no shell is used.

    Raises
    ------
    UsageError
        When it cannot be started, or does not say what it is.
    """

    def __init__(self, command: str) -> None:
        try:
            self.command = shlex.split(command)
        except ValueError as error:
            raise UsageError(f"the command {command!r} cannot be read ({error})") from None
        if not self.command:
            raise UsageError("cmd: must be followed by a program and its arguments")
        self.silences = 0
        self._shown = 0
        self._start_program()
        try:
            self._describe()
        except (GlmrefError, NotImplementedError) as error:
            self.close()
            raise UsageError(f"the program {self.command[0]!r}: {error}") from None
        except BaseException:
            self._end(patience=0.0)
            raise

    def _start_program(self) -> None:
        self._pending, self._searched, self._running = bytearray(), 0, True
        mark = uuid4().hex
        try:
            self.process = subprocess.Popen(
                self.command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                bufsize=0,
                start_new_session=True,
                env={**os.environ, MARK: mark},
            )
        except (OSError, ValueError) as error:
            raise UsageError(
                f"the program {self.command[0]!r} cannot be started ({reason(error)})"
            ) from None
        remember_group(self.process.pid, mark)
        for stream in (self.process.stdin, self.process.stdout, self.process.stderr):
            assert stream is not None
            os.set_blocking(stream.fileno(), False)

    def _describe(self) -> None:
        about = self._ask({"ask": "describe"}, None)
        for key in ("methods", "offers"):
            if not about.get(key):
                raise PipeError(f"the answer to `describe` must have {key!r}, got {_short(about)}")
        offers = about["offers"]
        if not isinstance(offers, list) or not all(isinstance(x, str) for x in offers):
            raise PipeError(f"`offers` must be a list of names, got {_short(offers)}")
        unknown = sorted(set(offers) - set(OPERATIONS))
        if unknown:
            told = _short(repr(unknown[0]))
            raise PipeError(f"`offers` must be among {', '.join(OPERATIONS)}, got {told}")
        self.methods, self.offers = about["methods"], tuple(offers)
        for key in ("tolerance", "epsilon", "problems", "starts"):
            if key in about:
                setattr(self, key, about[key])

    def __getattr__(self, name: str) -> Any:
        if name in OPERATIONS and name in self.__dict__.get("offers", ()):
            return self.__getattribute__(f"_{name}")
        raise AttributeError(name)

    def close(self) -> None:
        """End the program; it may take five seconds when its stdin ends."""
        self._end(patience=5.0)

    def _end(self, patience: float) -> None:
        """Close what the program reads, wait for its end, and end what is left of its group."""
        if not self._running:
            return
        self._running = False
        streams = (self.process.stdin, self.process.stdout, self.process.stderr)
        try:
            _close(streams[:1])
            deadline = time.monotonic() + patience
            while not self._gone() and time.monotonic() < deadline:
                self._drain()
                time.sleep(0.005)
        finally:
            # its number is that of its group only, while it is not waited for
            end_group(self.process.pid)
            _close(streams[1:])
            self.process.wait()

    def _gone(self) -> bool:
        """Return whether the program has ended; it is left for :meth:`_end` to wait for."""
        if self.process.returncode is not None:
            return True
        if not hasattr(os, "waitid"):
            return self.process.poll() is not None
        try:
            flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
            return os.waitid(os.P_PID, self.process.pid, flags) is not None
        except OSError:
            return self.process.poll() is not None

    # --- operations -----------------------------------------------------------------------------

    def _step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        values = y.reshape(-1, problem.dimension)
        answer = self._values(self._line("step", method, problem, t, h, values), problem)
        return _shaped(answer, values.shape)

    def _stages(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> Any:
        values = y.reshape(-1, problem.dimension)
        answer = self._values(self._line("stages", method, problem, t, h, values), problem)
        known = _known(method)
        stages = [len(c.A) for c in known.carriers]
        both = _shaped(answer, (sum(stages), problem.dimension // len(stages)))
        return both if len(stages) == 1 else (both[: stages[0]], both[stages[0] :])

    def _start(self, method: str, problem: Any, h: float) -> np.ndarray:
        t, y0 = problem.t_span[0], np.array(problem.y0)
        line = self._line("start", method, problem, t, h, y0[None, :], name="y0")
        known = _known(method)
        return _shaped(self._values(line, problem), (known.carried, len(y0)))

    def _finish(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        values = y.reshape(-1, problem.dimension)
        answer = self._values(self._line("finish", method, problem, t, h, values), problem)
        return _shaped(answer, (problem.dimension,))

    def _solve(
        self, method: str, problem: Any, h: float, steps: int, start: np.ndarray | None = None
    ) -> np.ndarray:
        t, y0 = problem.t_span[0], np.array(problem.y0)
        line = self._line("solve", method, problem, t, h, y0[None, :], name="y0")
        line["steps"] = steps
        if start is not None:
            line["start"] = start.ravel().tolist()
        answer = _numbers(self._values(line, problem))
        d = problem.dimension
        return _shaped(answer, (d,)) if answer.size == d else _shaped(answer, (steps + 1, d))

    def _line(
        self, ask: str, method: str, problem: Any, t: float, h: float, values: np.ndarray,
        name: str = "values",
    ) -> dict[str, Any]:  # fmt: skip
        return {
            "ask": ask, "method": method, "problem": problem.name,
            "separable": bool(problem.separable), "t": float(t), "h": float(h),
            "rows": values.shape[0], "columns": values.shape[1], name: values.ravel().tolist(),
        }  # fmt: skip

    # --- the wire -------------------------------------------------------------------------------

    def _values(self, line: dict[str, Any], problem: Any) -> Any:
        answer = self._ask(line, problem)
        if "values" not in answer:
            raise PipeError(
                f"the answer to {line['ask']!r} must have 'values', got {_short(answer)}"
            )
        return answer["values"]

    def _ask(self, line: dict[str, Any], problem: Any) -> dict[str, Any]:
        """Send a question and serve the program's own until it answers."""
        if self.silences >= _SILENCES:
            raise PipeError(f"the program is not asked any more: it was silent {_SILENCES} times")
        if not self._running:
            self._start_program()
        try:
            return self._answered(line, problem)
        except BaseException as error:
            # an answer that is an error leaves the wire in order; nothing else does
            if isinstance(error, BrokenPipe) or not isinstance(error, PipeError | NotOffered):
                self._end(patience=0.1)
            raise

    def _answered(self, line: dict[str, Any], problem: Any) -> dict[str, Any]:
        last = time.monotonic() + LONGEST
        if not self._pending and "stdout" in self._ready(False, 0.0):
            self._read()  # what came late, after the last answer
        if self._pending:
            raise BrokenPipe(
                f"the program wrote {_short(bytes(self._pending[:200]))} without being asked"
            )
        self._send(line, last)
        while True:
            answer = self._receive(last)
            if "error" in answer:
                raise PipeError(_short(answer["error"]))
            if "cannot" in answer:
                raise NotOffered(_short(answer["cannot"]))
            if "ask" not in answer:
                return answer
            self._send({"values": _served(answer, problem)}, last)

    def _send(self, line: dict[str, Any], last: float) -> None:
        """Write a line; meanwhile the program may write, too."""
        rest = memoryview(json.dumps(line).encode() + b"\n")
        assert self.process.stdin is not None
        while rest:
            rest = rest[self._exchange(rest, last) :]

    def _receive(self, last: float) -> dict[str, Any]:
        while (end := self._pending.find(b"\n", self._searched)) < 0:
            self._searched = len(self._pending)
            self._exchange(None, last)
        text = bytes(self._pending[:end])
        del self._pending[: end + 1]
        self._searched = 0
        try:
            answer = json.loads(text, object_pairs_hook=unique)
        except DataError:  # of two answers neither is the answer
            raise BrokenPipe("the program gives a key of its answer twice") from None
        except (ValueError, RecursionError):
            raise BrokenPipe(
                f"the program's line {_short(text[:200])} is not JSON; stdout is for answers, "
                f"stderr for anything else"
            ) from None
        if not isinstance(answer, dict):
            raise BrokenPipe(f"the program's line {_short(text[:200])} is not a JSON object")
        return answer

    def _exchange(self, out: memoryview | None, last: float) -> int:
        """Wait until something can be written or read, do it once, and return what was written.

        Raises
        ------
        BrokenPipe
            When the program is silent, gone, or takes or writes more than it may.
        """
        patience = time.monotonic() + PATIENCE
        while True:
            moment = time.monotonic()
            if moment >= min(patience, last):
                self.silences += 1
                raise BrokenPipe(
                    f"the program did not answer within {PATIENCE:g} seconds"
                    if moment < last
                    else f"the program asked and did not answer within {LONGEST:g} seconds"
                )
            gone = self._gone()
            ready = self._ready(out is not None, 0.0 if gone else min(_LOOK, patience - moment))
            if "stderr" in ready:
                self._drain()
            if "stdout" in ready:
                self._read()
                return 0
            if "stdin" in ready and out is not None:
                return self._write(out)
            if gone and not ready:  # a child that it left may keep the pipe open, silently
                raise self._ended()

    def _ready(self, writing: bool, seconds: float) -> set[str]:
        with selectors.DefaultSelector() as waiting:
            for name in ("stdout", "stderr"):
                stream = getattr(self.process, name)
                if not stream.closed:
                    waiting.register(stream, selectors.EVENT_READ, name)
            if writing and self.process.stdin is not None:
                waiting.register(self.process.stdin, selectors.EVENT_WRITE, "stdin")
            return {key.data for key, _ in waiting.select(max(0.0, seconds))}

    def _read(self) -> None:
        assert self.process.stdout is not None
        try:
            chunk = os.read(self.process.stdout.fileno(), 1 << 16)
        except BlockingIOError:
            return
        if not chunk:
            raise self._ended()
        self._pending += chunk
        if len(self._pending) > MAX_LINE:
            raise BrokenPipe(f"the program's line is longer than {MAX_LINE} bytes")

    def _write(self, out: memoryview) -> int:
        assert self.process.stdin is not None
        try:
            return os.write(self.process.stdin.fileno(), out[: 1 << 16])
        except BlockingIOError:
            return 0
        except OSError:
            raise self._ended() from None

    def _drain(self) -> None:
        """Read what the program writes to its stderr, and show its beginning on ours."""
        stream = self.process.stderr
        if stream is None or stream.closed:
            return
        try:
            chunk = os.read(stream.fileno(), 1 << 16)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        if not chunk:
            stream.close()
            return
        shown = chunk[: max(0, MAX_STDERR - self._shown)]
        self._shown += len(chunk)
        with contextlib.suppress(OSError, ValueError):
            if shown:
                text = shown.decode("utf-8", "backslashreplace")
                sys.stderr.write("\n".join(map(escaped, text.split("\n"))))
            if len(shown) < len(chunk) and self._shown - len(chunk) < MAX_STDERR:
                sys.stderr.write("\n[more of the program's stderr is not shown]\n")
            sys.stderr.flush()

    def _ended(self) -> BrokenPipe:
        """Say that the program is gone: seen when it is written to or read from, as it happens."""
        deadline = time.monotonic() + 1.0
        while not self._gone() and time.monotonic() < deadline:
            time.sleep(0.005)
        if not self._gone():
            return BrokenPipe("the program closed its stdout without an answer and runs on")
        self._drain()  # its last words
        self._end(patience=0.0)
        return BrokenPipe(f"the program ended without an answer ({_code(self.process.wait())})")


def _close(streams: Iterable[Any]) -> None:
    for stream in streams:
        if stream is not None:
            with contextlib.suppress(OSError):
                stream.close()


def _short(value: object) -> str:
    """Return what a program wrote as it may stand in a sentence."""
    text = value if isinstance(value, str) else repr(value)
    return text if len(text) <= 300 else f"{text[:300]}..."


def _code(code: int) -> str:
    """Return how a program ended."""
    return f"{'killed by ' if code < 0 else ''}{ending(code)}"


def _served(question: dict[str, Any], problem: Any) -> list[float]:
    """Evaluate what a program asks for."""
    kind = question["ask"]
    if problem is None or kind not in ("f", "jacobian", "dq", "dp"):
        raise BrokenPipe(f"the program asks {_short(repr(kind))}; it may ask f, jacobian, dq or dp")
    function = getattr(problem, kind)
    if function is None:
        raise BrokenPipe(f"the problem {problem.name!r} has no {kind}")
    d = problem.dimension
    name, size = ("y", d) if kind in ("f", "jacobian") else ("p" if kind == "dq" else "q", d // 2)
    try:
        given = _numbers(question[name])
        if np.shape(question[name]) != (size,):
            raise ValueError(f"{name!r} must have {size} numbers in one list")
        with np.errstate(all="ignore"):
            if name == "y":
                found = function(float(question["t"]), given)
            else:
                found = function(given)
    except (KeyError, TypeError, ValueError, ArithmeticError, PipeError) as error:
        text = _short(str(error))
        raise BrokenPipe(f"the program's question {kind!r} cannot be served ({text})") from None
    # JSON has no infinities; a program that leaves the domain hears null
    return [
        x if math.isfinite(x) else None for x in np.asarray(found, dtype=float).ravel().tolist()
    ]  # type: ignore[list-item]


def _flat(answer: Any) -> Iterator[float]:
    """Yield numbers of an answer.

    Null is what JSON has for no number, a text or a truth is none.
    """
    if isinstance(answer, list):
        for x in answer:
            yield from _flat(x)
    elif isinstance(answer, int | float) and not isinstance(answer, bool):
        yield answer
    elif answer is None:
        yield math.nan
    else:
        raise TypeError


def _numbers(answer: Any) -> np.ndarray:
    try:
        return np.fromiter(_flat(answer), dtype=float)
    except (TypeError, OverflowError, RecursionError):
        raise PipeError(f"`values` must be a list of numbers, got {str(answer)[:80]}") from None


def _shaped(answer: Any, shape: tuple[int, ...]) -> np.ndarray:
    found = _numbers(answer)
    if found.size != math.prod(shape):
        raise PipeError(
            f"{math.prod(shape)} numbers were expected, shape {shape}; got {found.size}"
        )
    return found.reshape(shape)


def _known(method: str) -> Any:
    from ..catalogue.lookup import load

    return load(method)
