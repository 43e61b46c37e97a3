"""The command: files of certificates in, one line for each certificate out."""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import signal
import sys
from collections.abc import Sequence
from typing import NoReturn

from .proof import read_certificate
from .refusals import NoCertificate, Refused, Unreadable, beyond, require
from .statements import RULES, verdict

SECONDS = 60  # of processor time for one certificate


MEGABYTES = 32  # size of a file


def printed(text: str) -> str:
    """Return a text of others on one line that a terminal does not obey."""
    return "".join(x if x.isprintable() else ascii(x)[1:-1] for x in text)


def no_float(text: str) -> NoReturn:
    """Refuse a JSON number that is not whole."""
    raise Refused(f"{text[:40]} is a JSON number that is not whole")


def no_twins(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Refuse an object that has a key twice."""
    found = dict(pairs)
    require(len(found) == len(pairs), "a key stands twice in one object")
    return found


def read(path: str) -> list[str]:
    """Return the texts of the certificates in a file: one, or one on each line."""
    try:
        # a pipe of the shell has no name; one that has may have no writer, and opening it waits
        if pathlib.Path(os.path.realpath(path)).is_fifo():
            raise Unreadable("it cannot be read: it is a named pipe")
        with open(path, "rb") as file:
            text = file.read(MEGABYTES * 2**20 + 1).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise Unreadable(f"it cannot be read: {error}") from error
    lines = [line for line in text.splitlines() if line.strip()]
    several = len(lines) > 1 and all(line[0] == "{" and line[-1] == "}" for line in lines)
    return lines if several and len(text) <= MEGABYTES * 2**20 else [text]


def check(text: str) -> tuple[bool, str]:
    """Return (accepted, sentence) for one certificate, within the limits of time and size.

    Raises
    ------
    Unreadable
        If the text is not JSON, or its value does not have the members of a certificate.
    """
    if hasattr(signal, "SIGPROF"):
        signal.signal(signal.SIGPROF, beyond)
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        require(len(text) <= MEGABYTES * 2**20, "beyond the limits of this checker")
        value = json.loads(text, parse_float=no_float, parse_constant=no_float,
                           object_pairs_hook=no_twins)  # fmt: skip
        read_certificate(value, RULES)
        return verdict(value)
    except json.JSONDecodeError as error:
        raise Unreadable(f"no JSON: {error}") from error
    except NoCertificate as error:
        raise Unreadable(f"no certificate: {error}") from error
    except Refused as refused:
        return False, str(refused)
    except (RecursionError, ValueError):
        return False, "beyond the limits of this checker"
    finally:
        if hasattr(signal, "SIGPROF"):
            signal.setitimer(signal.ITIMER_PROF, 0)


def main(arguments: Sequence[str] | None = None) -> int:
    """Check the files named and return the exit code."""
    parser = argparse.ArgumentParser(description="Check certificates of glmref-certificate-1.")
    parser.add_argument("files", nargs="+", metavar="FILE", help="one certificate, or one a line")
    code = 0
    for path in parser.parse_args(arguments).files:
        try:
            texts = read(path)
        except Unreadable as error:
            complain(path, error)
            code = 2
            continue
        for text in texts:
            try:
                accepted, sentence = check(text)
            except Unreadable as error:
                complain(path, error)
                code = 2
                continue
            answer = f"{path}: {'yes' if accepted else 'no'}: {sentence}"
            sys.stdout.write(f"{printed(answer)}\n")
            code = max(code, 0 if accepted else 1)
    return code


def complain(path: str, error: Exception) -> None:
    """Write one line to stderr."""
    sys.stderr.write(f"{printed(f'{path}: {error}')}\n")
