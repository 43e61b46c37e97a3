"""The process around a command: its streams, the signals that end it, and the children it leaves.

A program of this package is entered through :func:`guarded`. Whatever ends it (Ctrl-C, SIGTERM, a
reader of its output that goes away, a full disk) leads to one sentence at the most and to the exit
code that shells expect, and nothing that it started runs on.
"""

from __future__ import annotations

import contextlib
import faulthandler
import io
import json
import os
import signal
import socket
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any, NamedTuple

from .. import errors
from .budget import EXCESS, spent

#: 128 and the number of SIGINT or SIGPIPE, as shells count.
INTERRUPTED, PIPE_CLOSED = 130, 141
#: Seconds in which a command that is told to end may end by itself. Machine code that is compiled
#: or runs hears nothing of a signal; records are on the disk, so that ending at once loses nothing.
GRACE = 0.7

#: What tells a program that its time is over; Windows has no such signal.
TIME_OVER = getattr(signal, "SIGALRM", None)
#: What is said then, and the exit code, which is that of a refusal.
TOO_LONG, TOO_LONG_CODE = "the time limit is over; what was finished is printed or kept", 2

#: Process groups of programs that were started, to be ended with this process.
_groups: set[int] = set()
#: The signal that was received; an engine may turn the exception into an outcome of its own.
_received: list[int] = []


class Terminated(KeyboardInterrupt):
    """The process was told to end by a signal that is not Ctrl-C.

    Whoever cleans up after Ctrl-C does so after this as well.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_groups.clear)  # they are those of the parent


def remember_group(group: int) -> None:
    """Have a process group ended when this process is."""
    _groups.add(group)


def forget_group(group: int) -> None:
    """Take back what :func:`remember_group` was told."""
    _groups.discard(group)


def end_groups() -> None:
    """End the programs that were started and not ended yet."""
    for group in tuple(_groups):
        with contextlib.suppress(OSError):
            os.killpg(group, signal.SIGKILL)
        _groups.discard(group)


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
    """Point stdout and stderr at nothing where nobody reads them any more.

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


def _terminate(number: int, frame: FrameType | None) -> None:
    if _received:  # a second one must not stop what the first has begun to end
        return
    _received.append(number)
    raise KeyboardInterrupt if number == signal.SIGINT else Terminated(number)


@contextlib.contextmanager
def signals(name: str) -> Iterator[threading.Event]:
    """Turn the first of SIGINT, SIGTERM and SIGHUP into an exception, and end who does not hear it.

    SIGTERM and SIGHUP become :class:`Terminated`. Outside of the main thread nothing is changed;
    Windows has Ctrl-C only, and nothing that ends who does not hear it.

    Parameters
    ----------
    name : str
        The program, for the sentence of an end by force.

    Yields
    ------
    threading.Event
        Once it is set, the process is not ended by force any more.
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
    with _watched(ended, name) if posix else contextlib.nullcontext():
        before = {number: signal.signal(number, _terminate) for number in wanted}
        try:
            yield ended
        finally:
            ended.set()
            for number, handler in before.items():
                signal.signal(number, handler)


@contextlib.contextmanager
def _watched(ended: threading.Event, name: str) -> Iterator[None]:
    """Have a thread woken by signals, which ends the process where nothing else hears them."""
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    watcher = threading.Thread(target=_watch, args=(reader, ended, name), daemon=True)
    wakeup = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    watcher.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(wakeup)
        with contextlib.suppress(OSError):
            writer.send(b"\0")
        watcher.join(timeout=1.0)
        reader.close()
        writer.close()


def _watch(reader: socket.socket, ended: threading.Event, name: str) -> None:
    """Wait for a signal; end the process where it has not ended itself some time after it."""
    while True:
        try:
            number = reader.recv(1)
        except OSError:
            return
        if not number or number == b"\0":
            return
        if number[0] not in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, TIME_OVER):
            continue
        if signal.getsignal(number[0]) in (signal.SIG_IGN, signal.SIG_DFL):
            continue
        if not ended.wait(GRACE):
            _end_by_force(name, number[0])


def _end_by_force(name: str, number: int) -> None:
    end_children()
    with contextlib.suppress(OSError):
        os.write(2, f"{name}: {_word(number)}\n".encode())
    os._exit(_code(number))


def _code(number: int) -> int:
    return TOO_LONG_CODE if number == TIME_OVER else 128 + number


def _word(number: int) -> str:
    if number == TIME_OVER:
        return TOO_LONG
    return "interrupted" if number == signal.SIGINT else f"ended by {signal.Signals(number).name}"


def guarded(name: str, function: Callable[[], int], bad: int) -> int:
    """Run a program; no exception leaves this function, and no child outlives it.

    Parameters
    ----------
    name : str
        The program, as sentences on stderr begin.
    function : callable
        What it does; returns the exit code.
    bad : int
        The exit code where the system refuses something.

    Returns
    -------
    int
        The exit code: 130 after Ctrl-C, 143 after SIGTERM, 141 where nobody reads stdout.
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
        if sentence:
            with contextlib.suppress(OSError):
                print(f"{name}: {sentence}", file=sys.stderr, flush=True)  # noqa: T201
        silence()
    return code


def _outcome(function: Callable[[], int], bad: int) -> tuple[int, str]:
    """Exit code and sentence of what a program does."""
    try:
        code = function()
        sys.stdout.flush()
    except BrokenPipeError:
        return PIPE_CLOSED, ""
    except KeyboardInterrupt:
        return INTERRUPTED, _word(_received[-1] if _received else signal.SIGINT)
    except MemoryError:
        return bad, "the memory does not suffice; ask for less, or allow more (ulimit -v)"
    except OSError as error:
        what = error.strerror or error
        return bad, f"the system refused ({what}); free what it names, try again"
    return code, ""


# --- a limit of time ------------------------------------------------------------------------------


def _fork(program: Callable[[], int]) -> int:
    """Start a process that runs a program and ends; nothing of the caller runs a second time."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # threads: none that this package starts holds a lock
        child = os.fork()
    if child:
        return child
    code = 1
    try:
        code = program()
    except BaseException as error:
        sys.excepthook(type(error), error, error.__traceback__)
    finally:
        os._exit(code)


def within(name: str, seconds: float, program: Callable[[], int]) -> int:
    """Run a program in a child that is ended when its time is over, whatever it does then.

    A library that does not return holds the interpreter, and neither a signal nor a thread of its
    process can end it in a sentence. This process only waits, and hands on the signals it gets.

    Parameters
    ----------
    name : str
        The program, as sentences on stderr begin.
    seconds : float
        Wall-clock time.
    program : callable
        What it does, through :func:`guarded`; returns the exit code.

    Returns
    -------
    int
        The exit code of the program; 2 where its time is over.
    """
    if not hasattr(os, "fork") or TIME_OVER is None:
        print(f"{name}: this system has no time limits; leave it out", file=sys.stderr)  # noqa: T201
        return TOO_LONG_CODE
    open_streams()
    # a child would wait for ever for the thread of a timer that runs, which it does not have
    faulthandler.cancel_dump_traceback_later()

    def timed() -> int:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        nowhere = open(os.devnull, "w")  # noqa: SIM115
        # this timer, which needs no interpreter, serves where the parent is gone
        faulthandler.dump_traceback_later(2 * seconds + 1, exit=True, file=nowhere)
        return program()

    child, killed = 0, False
    early: list[int] = []

    def tell(number: int) -> None:
        if child:
            os.kill(child, number)
        else:
            early.append(number)

    def over(number: int, frame: FrameType | None) -> None:
        nonlocal killed
        if signal.getitimer(signal.ITIMER_REAL)[1]:  # the second time: it has not heard the first
            killed = True
            signal.setitimer(signal.ITIMER_REAL, 0)
        else:
            signal.setitimer(signal.ITIMER_REAL, 2 * GRACE, 2 * GRACE)
        tell(signal.SIGKILL if killed else number)

    def hand_on(number: int, frame: FrameType | None) -> None:
        if number != signal.SIGINT or not _in_foreground():  # Ctrl-C reaches the child by itself
            tell(number)

    # the handlers come before the child: a signal that finds none ends this process alone, and one
    # that is blocked here may find another thread of the caller
    handlers = {**dict.fromkeys((signal.SIGINT, signal.SIGTERM, signal.SIGHUP), hand_on),
                TIME_OVER: over}  # fmt: skip
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, handlers)
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()
              if signal.getsignal(number) is not signal.SIG_IGN}  # fmt: skip
    child = _fork(timed)
    for number in early:
        os.kill(child, number)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    try:
        _, status = os.waitpid(child, 0)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for number, handler in before.items():
            signal.signal(number, handler)
    code = os.waitstatus_to_exitcode(status)
    if killed or code == -TIME_OVER:  # the latter before it could hear
        with contextlib.suppress(OSError):
            os.write(2, f"{name}: {TOO_LONG}\n".encode())
        return TOO_LONG_CODE
    return 128 - code if code < 0 else code


#: Of time on the clock a program apart may take so many times its processor time.
CLOCK = 10.0
#: How a program apart ended whose time was over.
OVER = "time over"

#: Hands a JSON value to the caller. What comes next may take so many seconds of processor time, or
#: those that are left where none are given.
Say = Callable[[Any, float | None], None]


class Said(NamedTuple):
    """What a program apart said."""

    messages: list[Any]
    #: How its process was ended: :data:`OVER`, the name of a signal, an exit code, or ``""``.
    ended: str
    seconds: float  #: Processor time of its process.

    def error(self, budget: float) -> Exception:
        """Why what it did last has no answer."""
        if self.ended == OVER:
            return spent(budget, " within one operation")
        return RuntimeError(f"the process of the proof was ended by {self.ended}")


def apart(program: Callable[[Say], object], seconds: float) -> Said:
    """Run a program in a process that the system ends when its processor time is over.

    One operation of a library may compute for hours and hears no signal. So timers of the system
    end its process. Where the system gives no process, the program runs here, without an end.

    Parameters
    ----------
    program : callable
        What it does; its argument is a :data:`Say`.
    seconds : float
        Processor time until it says otherwise; :data:`~glmref.system.budget.EXCESS` is added.

    Raises
    ------
    GlmrefError
        As the program raised it.
    RuntimeError
        For any other exception of the program, with its traceback as a note.
    """
    messages: list[Any] = []
    read, write = os.pipe()
    try:
        child = _fork(lambda: _say_all(program, seconds, write))
    except (AttributeError, OSError):  # there is no fork, or no process is to be had
        os.close(read)
        program(lambda message, _: messages.append(message))
        return Said(messages, "", 0.0)
    finally:
        os.close(write)
    remember_group(child)
    try:
        with open(read, "rb") as stream:
            lines = stream.read().split(b"\n")[:-1]  # what is cut off is not said
    except BaseException:  # such as Ctrl-C
        os.kill(child, signal.SIGKILL)
        raise
    finally:
        _, status, usage = os.wait4(child, 0)
        forget_group(child)
    for line in map(json.loads, lines):
        if "raised" in line:
            raise _raised(*line["raised"])
        messages.append(line["said"])
    code = os.waitstatus_to_exitcode(status)
    ended = ending(code) if code else ""
    if -code in (TIME_OVER, signal.SIGPROF):
        ended = OVER
    return Said(messages, ended, usage.ru_utime + usage.ru_stime)


def _say_all(program: Callable[[Say], object], seconds: float, write: int) -> int:
    """Run a program apart. Signals end this process at once: the handlers are its caller's."""
    os.setpgid(0, 0)  # what a terminal sends is for the caller, who ends this process
    signal.set_wakeup_fd(-1)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGALRM, signal.SIGPROF):
        signal.signal(number, signal.SIG_DFL)
    # nor is it stopped where it writes on a terminal with `stty tostop`
    signal.signal(signal.SIGTTOU, signal.SIG_IGN)
    stream = open(write, "wb")  # noqa: SIM115

    def let(seconds: float) -> None:
        most = max(seconds, 0.0) + EXCESS
        signal.setitimer(signal.ITIMER_PROF, most)
        signal.setitimer(signal.ITIMER_REAL, CLOCK * most)

    def put(line: dict[str, Any]) -> None:
        stream.write(json.dumps(line).encode() + b"\n")
        stream.flush()

    def say(message: Any, seconds: float | None) -> None:
        put({"said": message})
        if seconds is not None:
            let(seconds)

    let(seconds)
    try:
        program(say)
    except Exception as error:
        put({"raised": [type(error).__name__, str(error), traceback.format_exc()]})
    return 0


def _raised(name: str, text: str, trace: str) -> Exception:
    """An exception as its process described it."""
    kind = MemoryError if name == "MemoryError" else getattr(errors, name, None)
    if kind is not None:
        return kind(text)
    error = RuntimeError(f"{name}: {text}")
    error.add_note(trace)
    return error


def _in_foreground() -> bool:
    """Whether a terminal sends Ctrl-C to this process and its children."""
    with contextlib.suppress(OSError):
        terminal = os.open("/dev/tty", os.O_RDONLY | os.O_NOCTTY)
        try:
            return os.tcgetpgrp(terminal) == os.getpgrp()
        finally:
            os.close(terminal)
    return False
