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
import socket
import sys
import threading
from collections.abc import Callable, Iterator
from types import FrameType

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
#: Signals that were received; an engine may turn the exception into an outcome of its own.
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
    _received.append(number)
    raise Terminated(number)


@contextlib.contextmanager
def signals(name: str) -> Iterator[None]:
    """Turn SIGTERM and SIGHUP into :class:`Terminated`, and end by force who does not hear.

    Outside of the main thread, and where signals have no numbers to wake a thread with, nothing is
    changed.

    Parameters
    ----------
    name : str
        The program, for the sentence of an end by force.
    """
    if threading.current_thread() is not threading.main_thread() or os.name != "posix":
        yield
        return
    wanted = [
        number
        for number in (signal.SIGTERM, signal.SIGHUP, TIME_OVER)
        if number
        and signal.getsignal(number) is signal.SIG_DFL  # nohup ignores SIGHUP, and is right
    ]
    before = {number: signal.signal(number, _terminate) for number in wanted}
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    ended = threading.Event()
    watcher = threading.Thread(target=_watch, args=(reader, ended, name), daemon=True)
    wakeup = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    watcher.start()
    try:
        yield
    finally:
        ended.set()
        signal.set_wakeup_fd(wakeup)
        for number, handler in before.items():
            signal.signal(number, handler)
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
    sentence = ""
    try:
        with signals(name):
            code = function()
            sys.stdout.flush()
    except BrokenPipeError:
        code = PIPE_CLOSED
    except KeyboardInterrupt:
        code = INTERRUPTED
        sentence = _word(_received[-1] if _received else signal.SIGINT)
    except MemoryError:
        sentence = "the memory does not suffice; ask for less, or allow more (ulimit -v)"
        code = bad
    except OSError as error:
        sentence = f"the system refused ({error.strerror or error}); free what it names, try again"
        code = bad
    if code == INTERRUPTED:
        end_children()
        code = _code(_received[-1]) if _received else code
        if code == TOO_LONG_CODE:  # also where an engine made an outcome of it
            sentence = TOO_LONG
    end_groups()
    if sentence:
        with contextlib.suppress(OSError):
            print(f"{name}: {sentence}", file=sys.stderr, flush=True)  # noqa: T201
    silence()
    return code


# --- a limit of time ------------------------------------------------------------------------------


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
    child = os.fork()
    if child == 0:
        code = 1
        try:
            nowhere = open(os.devnull, "w")  # noqa: SIM115
            # this timer, which needs no interpreter, serves where the parent is gone
            faulthandler.dump_traceback_later(2 * seconds + 1, exit=True, file=nowhere)
            code = program()
        except BaseException as error:
            sys.excepthook(type(error), error, error.__traceback__)
        finally:
            os._exit(code)  # nothing of the caller may run a second time
    killed = False

    def over(number: int, frame: FrameType | None) -> None:
        nonlocal killed
        if signal.getitimer(signal.ITIMER_REAL)[1]:  # the second time: it has not heard the first
            killed = True
            signal.setitimer(signal.ITIMER_REAL, 0)
        else:
            signal.setitimer(signal.ITIMER_REAL, 2 * GRACE, 2 * GRACE)
        os.kill(child, signal.SIGKILL if killed else number)

    def hand_on(number: int, frame: FrameType | None) -> None:
        if number != signal.SIGINT or not _in_foreground():  # Ctrl-C reaches the child by itself
            os.kill(child, number)

    handlers = {
        TIME_OVER: over,
        **dict.fromkeys((signal.SIGINT, signal.SIGTERM, signal.SIGHUP), hand_on),
    }
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()
              if signal.getsignal(number) is not signal.SIG_IGN}  # fmt: skip
    signal.setitimer(signal.ITIMER_REAL, seconds)
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


def _in_foreground() -> bool:
    """Whether a terminal sends Ctrl-C to this process and its children."""
    with contextlib.suppress(OSError):
        terminal = os.open("/dev/tty", os.O_RDONLY | os.O_NOCTTY)
        try:
            return os.tcgetpgrp(terminal) == os.getpgrp()
        finally:
            os.close(terminal)
    return False
