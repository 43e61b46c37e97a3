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
it; after three silences it is not asked any more.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import selectors
import shlex
import signal
import subprocess
import time
from typing import Any

import numpy as np

from ..errors import GlmrefError, UsageError

__all__ = ["OFFERS", "PipeAdapter", "PipeError"]

#: Seconds a program may take for one answer.
PATIENCE = 60.0
#: Silences after which a program is given up.
_SILENCES = 3
#: What a program may offer.
OFFERS = ("step", "stages", "start", "finish", "solve")


class PipeError(GlmrefError):
    """What a program answered, or that it did not."""


class BrokenPipe(PipeError):
    """The program broke the protocol: its next line could belong to any question."""


class PipeAdapter:
    """A program as an adapter.

    Args:
        command: the program and its arguments, as in a shell; no shell is used.

    Raises
    ------
        UsageError: when it cannot be started, or does not say what it is.
    """

    def __init__(self, command: str) -> None:
        try:
            self.command = shlex.split(command)
        except ValueError as error:
            raise UsageError(f"the command {command!r} cannot be read ({error})") from None
        if not self.command:
            raise UsageError("cmd: must be followed by a program and its arguments")
        self.silences = 0
        self._start_program()
        try:
            self._describe()
        except GlmrefError as error:
            self.close()
            raise UsageError(f"the program {self.command[0]!r}: {error}") from None

    def _start_program(self) -> None:
        self._pending, self._running = b"", True
        try:
            self.process = subprocess.Popen(
                self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
            )
        except OSError as error:
            raise UsageError(
                f"the program {self.command[0]!r} cannot be started ({error.strerror})"
            ) from None

    def _describe(self) -> None:
        about = self._ask({"ask": "describe"}, None)
        for key in ("methods", "offers"):
            if not about.get(key):
                raise PipeError(f"the answer to `describe` must have {key!r}, got {about}")
        self.methods = about["methods"]
        for key in ("tolerance", "epsilon", "problems", "starts"):
            if key in about:
                setattr(self, key, about[key])
        self.offers = tuple(about["offers"])
        unknown = sorted(set(self.offers) - set(OFFERS))
        if unknown:
            raise PipeError(f"`offers` must be among {', '.join(OFFERS)}, got {unknown[0]!r}")

    def __getattr__(self, name: str) -> Any:
        if name in OFFERS and name in self.__dict__.get("offers", ()):
            return self.__getattribute__(f"_{name}")
        raise AttributeError(name)

    def close(self) -> None:
        """End the program; it may take five seconds when its stdin ends."""
        self._end(patience=5.0)

    def _end(self, patience: float) -> None:
        self._running = False
        for stream in (self.process.stdin, self.process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        try:
            self.process.wait(timeout=patience)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    # --- operations -----------------------------------------------------------------------------

    def _step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        values = y.reshape(-1, problem.dimension)
        answer = self._values(self._line("step", method, problem, t, h, values), problem)
        return _shaped(answer, values.shape)

    def _stages(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> Any:
        from ..method import PartitionedGLM

        values = y.reshape(-1, problem.dimension)
        answer = self._values(self._line("stages", method, problem, t, h, values), problem)
        known = _known(method)
        if isinstance(known, PartitionedGLM):
            m = problem.dimension // 2
            both = _shaped(answer, (known.n_Q + known.n_P, m))
            return both[: known.n_Q], both[known.n_Q :]
        return _shaped(answer, (known.s, problem.dimension))

    def _start(self, method: str, problem: Any, h: float) -> np.ndarray:
        t, y0 = problem.t_span[0], np.array(problem.y0)
        line = self._line("start", method, problem, t, h, y0[None, :], name="y0")
        known = _known(method)
        r = getattr(known, "r_hat", known.r)
        return _shaped(self._values(line, problem), (max(known.r, r), len(y0)))

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
        answer = np.array(self._values(line, problem))
        d = problem.dimension
        return answer if len(answer) == d else _shaped(answer, (steps + 1, d))

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
            raise PipeError(f"the answer to {line['ask']!r} must have 'values', got {answer}")
        return answer["values"]

    def _ask(self, line: dict[str, Any], problem: Any) -> dict[str, Any]:
        """Send a question and serve the program's own until it answers."""
        if self.silences >= _SILENCES:
            raise PipeError(f"the program is not asked any more: it was silent {_SILENCES} times")
        if not self._running:
            self._start_program()
        try:
            return self._answered(line, problem)
        except BrokenPipe:
            self._end(patience=0.1)
            raise

    def _answered(self, line: dict[str, Any], problem: Any) -> dict[str, Any]:
        self._send(line)
        while True:
            answer = self._receive()
            if "error" in answer:
                raise PipeError(str(answer["error"]))
            if "cannot" in answer:
                raise NotImplementedError(str(answer["cannot"]))
            if "ask" not in answer:
                return answer
            self._send({"values": _served(answer, problem)})

    def _send(self, line: dict[str, Any]) -> None:
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps(line).encode() + b"\n")
        except OSError:
            raise self._ended() from None

    def _ended(self) -> BrokenPipe:
        """Say that the program is gone: seen when it is written to or read from, as it happens."""
        return BrokenPipe(f"the program ended without an answer ({_code(self.process.wait())})")

    def _receive(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        deadline = time.monotonic() + PATIENCE
        with selectors.DefaultSelector() as waiting:
            waiting.register(self.process.stdout, selectors.EVENT_READ)
            while b"\n" not in self._pending:
                if not waiting.select(max(0.0, deadline - time.monotonic())):
                    self.silences += 1
                    raise BrokenPipe(f"the program did not answer within {PATIENCE:g} seconds")
                chunk = os.read(self.process.stdout.fileno(), 1 << 16)
                if not chunk:
                    raise self._ended()
                self._pending += chunk
        text, _, self._pending = self._pending.partition(b"\n")
        try:
            answer = json.loads(text)
        except ValueError:
            raise BrokenPipe(
                f"the program's line {text[:80]!r} is not JSON; stdout is for answers, stderr for "
                f"anything else"
            ) from None
        if not isinstance(answer, dict):
            raise BrokenPipe(f"the program's line {text[:80]!r} is not a JSON object")
        return answer


def _code(code: int) -> str:
    """How a program ended."""
    if code >= 0:
        return f"exit code {code}"
    with contextlib.suppress(ValueError):
        return f"killed by {signal.Signals(-code).name}"
    return f"killed by signal {-code}"


def _served(question: dict[str, Any], problem: Any) -> list[float]:
    """Evaluate what a program asks for."""
    kind = question["ask"]
    if problem is None or kind not in ("f", "jacobian", "dq", "dp"):
        raise BrokenPipe(f"the program asks {kind!r}; it may ask f, jacobian, dq or dp")
    function = getattr(problem, kind)
    if function is None:
        raise BrokenPipe(f"the problem {problem.name!r} has no {kind}")
    try:
        if kind in ("f", "jacobian"):
            found = function(float(question["t"]), np.array(question["y"], dtype=float))
        else:
            found = function(np.array(question["p" if kind == "dq" else "q"], dtype=float))
    except (KeyError, TypeError, ValueError) as error:
        raise BrokenPipe(f"the program's question {kind!r} cannot be served ({error})") from None
    # JSON has no infinities; a program that leaves the domain hears null
    return [
        x if math.isfinite(x) else None for x in np.asarray(found, dtype=float).ravel().tolist()
    ]  # type: ignore[list-item]


def _shaped(answer: Any, shape: tuple[int, ...]) -> np.ndarray:
    try:
        found = np.array(answer, dtype=float).ravel()
    except (TypeError, ValueError):
        raise PipeError(f"`values` must be a list of numbers, got {str(answer)[:80]}") from None
    if found.size != math.prod(shape):
        raise PipeError(
            f"{math.prod(shape)} numbers were expected, shape {shape}; got {found.size}"
        )
    return found.reshape(shape)


def _known(method: str) -> Any:
    from ..catalogue.lookup import load

    return load(method)
