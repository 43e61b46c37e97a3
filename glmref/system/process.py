"""The process around a command: its streams, the signals that end it, and the children it leaves.

A program of this package is entered through :func:`guarded`. Whatever ends it (Ctrl-C, SIGTERM, a
reader of its output that goes away, a full disk) leads to one sentence at the most and to the exit
code that shells expect, and nothing that it started runs on.
"""

from __future__ import annotations

import contextlib
import faulthandler
import io
import os
import signal
import subprocess
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, NamedTuple

from .budget import EXCESS, spent

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

#: 128 and the number of SIGINT or SIGPIPE, as shells count.
INTERRUPTED, PIPE_CLOSED = 130, 141
#: Seconds in which a command that is asked to end may end by itself. Machine code that is compiled
#: or runs hears nothing of a signal; records are on the disk, so that ending at once loses nothing.
GRACE = 0.7

#: What tells a program that its time is over; Windows has no such signal.
TIME_OVER = getattr(signal, "SIGALRM", None)
#: What is said then, and the exit code, which is that of a refusal.
TOO_LONG, TOO_LONG_CODE = "the time limit is over; what was finished is printed or kept", 2

#: Process groups of programs that were started, to be ended with this process: group -> mark.
_groups: dict[int, str] = {}
#: Environment variable that marks a program and what it starts, whatever group that moves to.
MARK = "GLMREF_PROGRAM"
#: The signal that was received; an engine may turn the exception into an outcome of its own.
_received: list[int] = []


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_groups.clear)  # they are those of the parent


def remember_group(group: int, mark: str = "") -> None:
    """Have a process group ended when this process is.

    ``mark`` is the value of :data:`MARK` in its environment, by which members that left it are
    found.
    """
    _groups[group] = mark


def end_group(group: int) -> None:
    """Kill a process group, and what it started that has left it by ``setsid``."""
    with contextlib.suppress(OSError):
        os.killpg(group, signal.SIGKILL)
    mark = _groups.pop(group, "")
    for _ in range(_ROUNDS if mark else 0):
        found = _marked(mark)
        for pid in found:
            with contextlib.suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        if not found:
            break


#: How often marked processes are looked for: one may start another between two looks.
_ROUNDS = 20


def _marked(mark: str) -> list[int]:
    """Return the processes with a mark in their environment, where the system shows it (Linux)."""
    found, wanted = [], f"{MARK}={mark}".encode()
    for place in Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):  # gone, or of another user; that of a zombie is empty
            if wanted in place.read_bytes().split(b"\0"):
                found.append(int(place.parent.name))
    return found


def end_groups() -> None:
    """End the programs that were started and not ended yet."""
    for group in tuple(_groups):
        end_group(group)


def end_children() -> None:
    """End everything that this process started: programs, and processes that share its work."""
    end_groups()
    if "multiprocessing" in sys.modules:
        from multiprocessing import active_children  # in memory already

        for child in active_children():
            if child._parent_pid == os.getpid():  # type: ignore[attr-defined]
                child.kill()


def ending(code: int) -> str:
    """Return how a process ended: its exit code, or the name of a signal."""
    if code >= 0:
        return f"exit code {code}"
    with contextlib.suppress(ValueError):  # one without a name
        return signal.Signals(-code).name
    return f"signal {-code}"


def end_with_parent() -> None:
    """Have this process, started by `multiprocessing`, end when its parent does, even if killed."""
    # few processes are started by multiprocessing, and it takes a while to load
    from multiprocessing import parent_process
    from multiprocessing.connection import wait  # as above

    parent = parent_process()
    if parent is None:
        return

    def follow() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


# --- streams --------------------------------------------------------------------------------------


def open_streams() -> None:
    """Make sure that there are streams, and that no character can stop them.

    A stream that the caller closed (``glmref list >&-``) leaves its number free, and the next file
    that is opened would get it: a record file that is number 1 receives what a library prints.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            with contextlib.suppress(OSError):
                os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free
    if sys.stdin is None:
        sys.stdin = open(os.devnull)  # noqa: SIM115
    elif isinstance(sys.stdin, io.TextIOWrapper):
        sys.stdin.reconfigure(encoding="utf-8")  # as files are read, whatever the terminal has
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def silence() -> None:
    """Point stdout and stderr at nothing where they are no longer read.

    Otherwise what is left in their buffers fails once more, when the interpreter ends.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        try:
            stream.flush()
        except OSError:
            with contextlib.suppress(OSError, ValueError):
                null = os.open(os.devnull, os.O_WRONLY)
                os.dup2(null, stream.fileno())
                os.close(null)
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115


# --- signals --------------------------------------------------------------------------------------


def _interrupt(number: int, frame: FrameType | None) -> None:
    if not _received:  # a second one must not stop what the first has begun to end
        _received.append(number)
        raise KeyboardInterrupt


@contextlib.contextmanager
def signals(name: str) -> Iterator[threading.Event]:
    """Convert the first SIGINT, SIGTERM, SIGHUP or SIGALRM into a ``KeyboardInterrupt``.

    The process, called ``name``, is killed where it does not react within :data:`GRACE`, but not
    any more once the event is set that is given. Outside of the main thread nothing is changed;
    Windows has Ctrl-C only, and nothing that kills the process.
    """
    ended = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield ended
        return
    posix = os.name == "posix"
    wanted = [
        number
        for number in ((signal.SIGTERM, signal.SIGHUP, signal.SIGALRM) if posix else ())
        if signal.getsignal(number) is signal.SIG_DFL  # nohup ignores SIGHUP, and is right
    ]
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        wanted.append(signal.SIGINT)
    with _killer(ended, name) if posix else contextlib.nullcontext():
        before = {number: signal.signal(number, _interrupt) for number in wanted}
        try:
            yield ended
        finally:
            ended.set()
            for number, handler in before.items():
                signal.signal(number, handler)


@contextlib.contextmanager
def _killer(ended: threading.Event, name: str) -> Iterator[None]:
    """Have a thread kill the process where no handler of a signal runs, as in machine code."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)

    def watch() -> None:
        while number := os.read(reader, 1):
            if signal.getsignal(number[0]) is _interrupt and not ended.wait(GRACE):
                end_children()
                if not (number[0] == TIME_OVER and _limited):  # the parent says it
                    _write_error(name, _sentence(number[0]))
                os._exit(_code(number[0]))

    watcher = threading.Thread(target=watch, daemon=True)
    wakeup = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    watcher.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(wakeup)
        os.close(writer)
        watcher.join(timeout=1.0)
        os.close(reader)


def _code(number: int) -> int:
    return TOO_LONG_CODE if number == TIME_OVER else 128 + number


def _sentence(number: int) -> str:
    if number == TIME_OVER:
        return TOO_LONG
    return "interrupted" if number == signal.SIGINT else f"ended by {signal.Signals(number).name}"


def _write_error(name: str, sentence: str) -> None:
    with contextlib.suppress(OSError):
        os.write(2, f"{name}: {sentence}\n".encode())


def guarded(name: str, function: Callable[[], int], bad: int) -> int:
    """Run a program; no exception leaves this function, and no child outlives it.

    Sentences on stderr begin with its name. Returns its exit code, ``bad`` where the system refuses
    something, 130 after Ctrl-C, 143 after SIGTERM, 141 where stdout is closed.
    """
    open_streams()
    _received.clear()
    with signals(name) as ended:
        code, sentence = _outcome(function, bad)
        if code == INTERRUPTED:
            end_children()
            code = _code(_received[-1]) if _received else code
            if code == TOO_LONG_CODE:  # also where an engine made an outcome of it
                sentence = TOO_LONG
        end_groups()
        ended.set()
        if sentence and not (sentence is TOO_LONG and _limited):
            with contextlib.suppress(OSError):
                print(f"{name}: {sentence}", file=sys.stderr, flush=True)  # noqa: T201
        silence()
    return code


def _outcome(function: Callable[[], int], bad: int) -> tuple[int, str]:
    """Return exit code and sentence of what a program does."""
    try:
        code = function()
        sys.stdout.flush()
    except BrokenPipeError:
        return PIPE_CLOSED, ""
    except KeyboardInterrupt:
        return INTERRUPTED, _sentence(_received[-1] if _received else signal.SIGINT)
    except MemoryError:
        return bad, "the memory does not suffice; ask for less, or allow more (ulimit -v)"
    except OSError as error:
        what = error.strerror or error
        return bad, f"the system refused ({what}); free what it names, try again"
    return code, ""


# --- a limit of time ------------------------------------------------------------------------------

#: Set in the surroundings of a program that :func:`within` runs.
LIMITED = "_GLMREF_LIMITED"
#: Whether this process is such a program.
_limited = False


def within(name: str, seconds: float, command: Sequence[str]) -> int:
    """Run a command in a process that is ended when its time is over, whatever it does then.

    A library that does not return holds the interpreter, and neither a signal nor a thread of its
    process can end it in a sentence. This process only waits, and passes on the signals it gets.
    The command calls :func:`limited_by_parent`, and :func:`guarded` for what it does. Returns its
    exit code; 2 where its time on the clock is over.
    """
    open_streams()
    if TIME_OVER is None:
        _write_error(name, "this system has no time limits; leave it out")
        return TOO_LONG_CODE
    received: list[int] = []
    child: subprocess.Popen[bytes] | None = None

    def pass_on(number: int, frame: FrameType | None) -> None:
        received.append(number)
        if child is not None:
            child.send_signal(number)

    # the handlers come before the child: a signal that finds none would end this process alone
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, TIME_OVER)
    before = {number: signal.signal(number, pass_on) for number in numbers
              if signal.getsignal(number) is not signal.SIG_IGN}  # fmt: skip
    try:
        child = subprocess.Popen(command, env={**os.environ, LIMITED: str(seconds)})
        for number in received[:]:
            child.send_signal(number)
        code = TOO_LONG_CODE
        for patience, number in ((seconds, TIME_OVER), (2 * GRACE, signal.SIGKILL)):
            try:
                code = child.wait(patience)
                break
            except subprocess.TimeoutExpired:
                pass_on(number, None)
        child.wait()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    over = TIME_OVER in received
    if code == -TIME_OVER or (over and code == TOO_LONG_CODE):  # the former before it could react
        # said here, once: a child that has said it may still be killed while it ends
        _write_error(name, TOO_LONG)
        return TOO_LONG_CODE
    return 128 - code if code < 0 else code


def limited_by_parent() -> bool:
    """Return whether :func:`within` runs this process, which ends soon after its time in any case.

    The timer that ends it needs no interpreter, and serves where the parent was killed.
    """
    global _limited
    seconds = os.environ.pop(LIMITED, None)
    _limited = seconds is not None
    if seconds is not None:
        nowhere = open(os.devnull, "w")  # noqa: SIM115
        faulthandler.dump_traceback_later(2 * float(seconds) + 1, exit=True, file=nowhere)
    return seconds is not None


#: Of time on the clock a program apart may take so many times its processor time.
CLOCK = 10.0
#: How a program apart ended whose time was over.
OVER = "time over"

#: Hands a value to the caller. What comes next may take so many seconds of processor time, or
#: those that are left where none are given.
Say = Callable[[Any, float | None], None]


class Said(NamedTuple):
    """What a program apart said."""

    messages: list[Any]
    #: How its process was ended: :data:`OVER`, the name of a signal, an exit code, or ``""``.
    ended: str
    seconds: float  #: Processor time of its process.

    def error(self, budget: float) -> Exception:
        """Return why what it did last has no answer."""
        if self.ended == OVER:
            return spent(budget, " within one operation")
        return RuntimeError(f"the process of the proof was ended by {self.ended}")


def apart(program: Callable[[Say], object], seconds: float) -> Said:
    """Run a program in a process that the system ends when its processor time is over.

    One operation of a library may compute for hours and reacts to no signal. So timers of the
    system end its process, after these seconds, until it says otherwise, and
    :data:`~glmref.system.budget.EXCESS`. Where the system gives no process, the program runs here,
    without an end.

    Raises
    ------
    Exception
        As the program raised it, with its traceback as a note.
    """
    # few programs run apart, and it takes a while to load
    from multiprocessing import get_context

    messages: list[Any] = []
    try:
        context = get_context("fork")
        reader, writer = context.Pipe(duplex=False)
        child = context.Process(target=_run_apart, args=(program, seconds, writer), daemon=True)
        before = _seconds_of_children()
        # an interrupt within the fork would leave a child that nothing ends
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, _INTERRUPTS)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # threads: none of this package holds a lock
                child.start()
        except OSError:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
            raise
    except (ValueError, OSError):  # there is no fork, or no process is to be had
        program(lambda message, _: messages.append(message))
        return Said(messages, "", 0.0)
    raised: Exception | None = None
    try:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        writer.close()
        with contextlib.suppress(EOFError, OSError):
            while raised is None:
                message, raised = reader.recv()
                if raised is None:
                    messages.append(message)
    except BaseException:  # such as Ctrl-C
        child.kill()
        raise
    finally:
        child.join()
        reader.close()
    if raised is not None:
        raise raised
    code = child.exitcode or 0
    over = -code in (TIME_OVER, signal.SIGPROF)
    ended = OVER if over else ending(code) if code else ""
    return Said(messages, ended, _seconds_of_children() - before)


#: The signals that interrupt a command, where the system has them.
_INTERRUPTS = {
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
}


def _seconds_of_children() -> float:
    times = os.times()
    return times.children_user + times.children_system


def _run_apart(program: Callable[[Say], object], seconds: float, writer: Connection) -> None:
    """Run a program in its process. Signals end it at once: the handlers are its caller's."""
    signal.set_wakeup_fd(-1)
    for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGALRM, signal.SIGPROF):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the caller, who kills it
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _INTERRUPTS)

    def allow(seconds: float) -> None:
        most = max(seconds, 0.0) + EXCESS
        signal.setitimer(signal.ITIMER_PROF, most)
        signal.setitimer(signal.ITIMER_REAL, CLOCK * most)

    def say(message: Any, seconds: float | None) -> None:
        writer.send((message, None))
        if seconds is not None:
            allow(seconds)

    allow(seconds)
    try:
        program(say)
    except Exception as error:
        error.add_note(traceback.format_exc())
        try:
            writer.send((None, error))
        except Exception:  # it cannot be sent as it is
            writer.send((None, RuntimeError(f"{type(error).__name__}: {error}")))
