"""What a table of a public code is: its order, and how many digits hold.

Numbers are taken as they are printed and computed in balls of 512 bits: a residual is known to 150
digits, so that its size says what the printing did to the table.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..errors import BudgetError, GlmrefError
from ..exact import Exact
from ..prove.schemes import LARGEST, Reach, further
from ..prove.wrong_entry import (
    Trial,
    abscissa,
    at_row,
    beside_weights,
    correction,
    digit,
    embedded,
    empty_rows,
    enters_nothing,
    estimate,
    exchanged,
    exchanged_weights,
    mirrored,
    one_row_apart,
    one_weight,
    unordered,
    vector,
    weight,
)
from ..system.budget import limited
from .entries import LOOSE
from .kinds import in_one_form
from .nearest_method import Library
from .table import ZERO, Rows, Table

#: What a table is of which nothing is asked.
_GOOD = ("right", "digits", "found")
#: Seconds of processor time for one table.
SECONDS = 120.0


def judge(table: Table, library: Library | None = None, *, search: bool = True) -> dict[str, Any]:
    """Return the record of a table.

    Returns
    -------
    dict
        JSON-ready: ``name``, ``line``, ``kind``, ``stages``, ``declared``, ``found``, ``status``
        (right, digits, wrong, question, found, unread), ``residual`` of ``tree``, or the largest
        through the declared order where no tree is named, ``remarks``, and ``correction``,
        ``nearest`` where there are any.
    """
    record: dict[str, Any] = {"name": table.name, "line": table.line, "kind": table.kind}
    if table.unread:
        question = table.unread.startswith("question: ")
        record["status"] = "question" if question else "unread"
        record["remarks"] = [table.unread.removeprefix("question: ")]
        return record
    record["stages"] = len(table.b[0]) - (table.kind == "composition")
    try:
        with limited(SECONDS):
            _judge(table, record, library, search)
    except BudgetError as error:
        record |= {"status": "unread", "remarks": [f"not decided: {error}"]}
    except (IndexError, ValueError):
        rows = [row for A in table.A for row in (A, *A)]
        sizes = {len(x) for x in (*rows, *table.b, *filter(None, table.c))}
        said = f"rows and columns of A, b and c have the sizes {sorted(sizes)}"
        if len(sizes) < 2:
            said = "what is read here does not make a tableau"
        record |= {"status": "unread", "remarks": [said]}
    except (GlmrefError, KeyError, ZeroDivisionError) as error:
        record |= {"status": "unread", "remarks": [f"{type(error).__name__}: {error}"]}
    return record


def _judge(table: Table, record: dict[str, Any], library: Library | None, search: bool) -> None:
    method = Trial(table)
    remarks: list[str] = []
    if table.pair is not None and len(table.rows) == 1:
        _share(table, method)
    found = _reached(table, method)
    status = _order(table, method, found, record, remarks)
    if method.quadratic:
        remarks.append("the order is that on q'' = g(q)")
    if status == "digits" and search and method.gap > 1e-12 and table.order is not None:
        record["correction"] = digit(method, table.order, found.size(table.order))
        status = "wrong" if record["correction"] else status
    if method.gap > 1e-12:
        k = method.gap_row
        remarks.append(f"c[{k + 1}] differs from the sum of row {k + 1} of A by {method.gap:.2g}")
    low = table.kind == "rosenbrock" and found.to(method.coarse) < (table.order or 1)
    for said, gap in table.identities:
        if gap > method.fine and not low:  # else a wrong entry is the reason
            remarks.append(f"{said} fails by {gap:.2g}")
            status = "wrong" if gap > method.coarse else status
    status = _rows(table, method, found, status, remarks)
    status = _estimates(table, method, status, remarks)
    status = _dense(table, method, status, remarks)
    if library is not None:
        _alike(table, library, status, record, remarks)
    remarks += empty_rows(table)
    remarks += _unseen(table, method)
    if table.general and status in _GOOD and search:
        said = unordered(method)
        remarks += said
        status = "question" if said else status
    status = _stage(method, status, record, remarks)
    status = _explained(table, method, status, record, remarks, search=search)
    if record["found"] == 0 and status not in ("unread", "wrong"):  # whatever a label means
        remarks.append("the order is 0: the weights do not sum to 1")
        named = any(table.c) or not (table.general and table.kind != "rk")
        tableau = table.order is not None or (named and method.gap <= method.coarse)
        mended = table.kind == "composition" and bool(record.get("correction"))
        likely = mended or _computed(table, method)
        status = "wrong" if tableau else "question" if likely else "unread"
        if status == "unread":
            said = "c is not the sums of the rows either" if any(table.c) else "there is no c"
            remarks.append(f"{said}: this may be no tableau")
    if table.general:
        status = _meant(table, method, status, record, remarks)
    record["status"] = status
    record["remarks"] = remarks
    for x in (*record.get("correction", ()), *record.get("nearest", {}).get("entries", ())):
        place = _place(table, x["entry"])
        if place is not None:
            x["line"], x["text"] = place


def _meant(
    table: Table, method: Trial, status: str, record: dict[str, Any], remarks: list[str]
) -> str:
    """Return the status of a table that was recognised by what it is.

    One that is not sure to be meant as it is read is a question, and so is one without a declared
    order where one entry, or a method of the catalogue, says what the table should be.
    """
    if status != "right" and not table.followed:
        remarks.append("slopes of the step go to a call, or a statement, that is not followed")
        return "unread"
    times = (method.c[0] if method.kind == "rk" and method.c else None) or []
    if status in ("wrong", "question") and [complex(x) for x in times[:1] + times[-1:]] == [1, 0]:
        remarks.append("the nodes go from 1 to 0: this may be the table of an adjoint")
        return "unread"
    found = record["found"]
    few = 2 if len(method.b[0]) > 2 else 1  # two entries of two stages make another method
    explained = record.get("correction") or record.get("nearest", {}).get("differing", 9) <= few
    explained = explained or any(" is that of " in x or x.startswith("with weight ")
                                 for x in remarks)  # fmt: skip
    declared = any("is declared of order" in x for x in remarks)  # of a row, by its own variable
    if status == "wrong" and declared and found >= (table.order or 0):
        return status
    explained = explained or (table.kind == "rosenbrock" and found == 0)  # by four names
    explained = explained or any(found == 0 or gap > method.coarse for _, gap in table.identities)
    beside = ("exchanged", "embedded weights", "dense output")
    rows = any(word in x for word in beside for x in remarks)
    entry = len(record.get("correction", ())) == 1 and (
        one_row_apart(method) or method.kind == "additive"
    )
    entry = entry or any(x.startswith("with error weight") for x in remarks)
    near = record.get("nearest", {})
    slip = table.computed and near.get("differing") == 1 and near.get("order", 0) > found
    if status in ("wrong", "question") and table.guessed and (entry or slip):
        return "question"  # what is right says that these are weights
    if status in ("wrong", "question") and table.guessed:
        remarks.append(
            "the last row of A, or that of an estimate, is taken for weights, as no others are read"
        )
        return "unread"
    if (
        status in ("wrong", "question")
        and found == 0
        and any(table.c)
        and not (explained or rows or one_row_apart(method) or _computed(table, method))
        and method.gap > method.coarse
    ):
        remarks.append("c is not the sums of the rows either: this may be no tableau")
        return "unread"
    sure = table.sure or (table.kind == "composition" and table.doubt and 0 < found < 4)
    if status in ("wrong", "question") and not sure and not (
        explained or rows or one_row_apart(method) or (found == 0 and _computed(table, method))
    ):  # fmt: skip
        remarks.append("matrix, weights or order may not be meant as they are read")
        return "unread"
    if status == "wrong" and not table.sure:
        remarks.append(
            table.doubt or "no variable says that this order, or these weights, are meant"
        )
        return "question"
    if status != "found":
        return status
    pair = _exchanged_nodes(method)
    if pair:
        line = _line((table.c[0] or [])[pair[0] :])
        remarks.append(f"c[{pair[0] + 1}] and c[{pair[1] + 1}] are exchanged{line}")
        return "question"
    if one_row_apart(method):
        for order in range(8, max(found, 2), -1):  # two rows and order 2 are no evidence
            mended = at_row(method, order) or abscissa(method, order)
            if mended:
                record["correction"] = mended
                remarks.append(f"with this entry the order is {order}")
                return "question"
    if method.kind in ("rosenbrock", "low-storage", "shu-osher") and 2 < len(method.b[0]):
        for order in (4, 3) if found < 3 else ():  # more conditions than one entry satisfies
            mended = correction(method, order) if order > found + 1 else []
            if 0 < len(mended) < 3:
                record["correction"] = mended
                remarks.append(f"with {'one of these entries' if mended[1:] else 'this entry'} the "
                               f"order is {order}")  # fmt: skip
                return "question"
    if 0 < near.get("differing", 0) <= 2 and near.get("order", 0) > found:
        remarks.append(f"the order of the nearest method is {near['order']}")
        return "question"
    return status


def _exchanged_nodes(method: Trial) -> list[int]:
    """Return the two stages of which each has the node that is the sum of the other's row."""
    c = (method.c[0] if method.kind == "rk" and method.c else None) or []
    sums = [sum(row, Exact(0)) for row in method.A[0]] if c else []
    apart = [k for k, x in enumerate(sums) if abs(complex(x - c[k])) > method.coarse]
    cross = [abs(complex(sums[k] - c[j])) for k, j in zip(apart, apart[::-1], strict=True)]
    return apart if len(apart) == 2 and max(cross) <= method.coarse else []


def _computed(table: Table, method: Trial) -> bool:
    """Return whether a step computes the table, and most of its rows sum to the times of stages."""
    c = method.c[0] if method.kind == "rk" and method.c else None
    if not table.computed or c is None or len(c) < 3:
        return False
    good = [abs(complex(sum(row, Exact(0)) - x)) <= method.coarse
            for row, x in zip(method.A[0], c, strict=True)]  # fmt: skip
    return 2 * sum(good) > len(good)


_ENTRY = re.compile(r"(a|alpha|gamma|beta|b|c|A|B)(_implicit|_prime)?\[(\d+)\](?:\[(\d+)\])?")


def _place(table: Table, entry: str) -> tuple[int, str] | None:
    """Return the line and the text of an entry by its name, where its reader noted them."""
    m = _ENTRY.fullmatch(entry)
    if entry.startswith("w["):  # a weight of a composition, whose kicks are its weights
        return table.b[1][int(entry[2:-1]) - 1].place
    if m is None:
        return None
    part, i = int(m[2] is not None or m[1] in ("gamma", "beta", "B")), int(m[3]) - 1
    try:
        if m[4]:
            return table.A[part][i][int(m[4]) - 1].place
        part += m[1] == "b" and table.kind == "splitting"
        row = (table.c if m[1] == "c" else table.b)[part]
        return row[i].place if row is not None else None
    except IndexError:
        return None


def _share(table: Table, method: Trial) -> None:
    """Give b the lower of two declared orders where it has that one, and the row the other."""
    low, high = table.pair or (0, 0)
    table.order = low if low < high else high
    reached = _reached(table, method).to(method.coarse)
    table.order = low if reached == low else high
    (label, row, _), other = table.rows[0], high if reached == low else low
    table.rows = [(label, row, other)]


def _reached(table: Table, method: Trial) -> Reach:
    """Return how far the conditions hold, one order beyond the declared one."""
    most = (table.order or (5 if len(table.b[0]) < 8 else 8)) + 1
    found = method.reached(most)
    if table.order is not None and found.to(method.coarse) == LARGEST[1]:
        found = further(found, method.scheme(), table.order)
    return found


def _order(
    table: Table, method: Trial, found: Reach, record: dict[str, Any], remarks: list[str]
) -> str:
    """Compare the declared order with the one found, and return the status."""
    fine, coarse, declared = method.fine, method.coarse, table.order
    record |= {"declared": declared, "found": found.to(coarse)}
    if declared is None or (table.kind == "composition" and not table.sure):
        record["residual"] = float(f"{found.size(record['found'] or 1):.2g}")
        if table.kind == "composition" and record["found"] < 4:
            cubes = complex(sum((x.value**3 for x in table.b[1]), Exact(0))).real
            remarks.append(
                f"the sum of the cubes of the weights is {cubes:.3g}, for order 4 it is 0"
            )
            mended = weight(method, 4)
            if mended:
                record["correction"] = mended
            return "question"
        if declared is None:
            return "found"
    looked = min(declared, len(found.sizes))
    size = found.size(looked)
    status = "right" if size <= fine else "digits" if size <= coarse else "wrong"
    record["residual"] = float(f"{size:.2g}")
    if status != "right":  # of rounded numbers the worst tree, else one of the first order
        bad = found.sizes.index(size) if status == "digits" else found.to(coarse)
        record["residual"] = float(f"{found.sizes[bad]:.2g}")
        record["tree"] = found.trees[bad]
        record["order_of_tree"] = bad + 1
    if looked < declared and status == "right":
        remarks.append(f"trees of order {looked} or less were looked at")
    return status


_AS_WEIGHTS = "they have an order as weights: embedded ones may stand in place of their difference"


def _estimates(table: Table, method: Trial, status: str, remarks: list[str]) -> str:
    """Judge the weights of error estimates, which sum to 0."""
    for error in table.errors:
        if status in ("wrong", "question") and table.order:
            remarks += exchanged(method, vector(error), table.order)
        total = abs(complex(sum(vector(error), Exact(0))))
        if total > 1e-12 * method.scale:
            remarks.append(f"the weights of the error estimate sum to {total:.3g}, not to 0")
            row = list(vector(error))
            weights = len(row) == len(method.b[0]) and method.reached(2, row).to(method.coarse)
            longer = len(row) == len(method.b[0]) + 1 and method.kind == "rk"
            over = Trial(_next_slope(table)) if longer else method
            said = [_AS_WEIGHTS] if weights else estimate(over, row)
            other = total >= 0.5 and abs(total - 1) > LOOSE  # perhaps another list of this name
            if table.general and other and not said:
                remarks.pop()
                continue
            k = re.search(r"error weight (\d+) =", " ".join(said))
            remarks += [f"{x}{_line(error[int(k[1]) - 1 :] if k else error)}" for x in said]
            if total > method.coarse and status in _GOOD:
                status = "wrong"
            continue
        said = exchanged_weights(method, vector(error))
        remarks += [f"{x}{_line(error[int(x.split()[3]) - 1 :])}" for x in said]
        status = "question" if said and status in _GOOD else status
    return status


def _next_slope(table: Table) -> Table:
    """Return a method with the slope at its end as a further stage, as an estimate may have it."""
    A = [[*row, ZERO] for row in (*table.A[0], table.b[0])]
    return replace(table, A=[A], b=[[*table.b[0], ZERO]], c=[None], rows=[], errors=[])


def _dense(table: Table, method: Trial, status: str, remarks: list[str]) -> str:
    """Ask about a dense output whose end is not b, or which is of order 1.

    The sum of a row is its weight at the end of the step.
    """
    for name, rows in table.dense:
        said = []
        for k, (row, x) in enumerate(zip(rows, method.b[0], strict=False), 1):
            gap = complex(sum(vector(row), Exact(0)) - x).real
            if abs(gap) > method.coarse:
                said.append(f"row {k} of {name}, a dense output, sums to b[{k}] {gap:+.3g}"
                            + _in_column(rows, k - 1, gap, method.coarse))  # fmt: skip
        c = [sum(row, Exact(0)) for row in method.A[0]]
        moments = [
            complex(sum((x * y for x, y in zip(column, c, strict=False)), Exact(0))).real
            for column in zip(*map(vector, rows), strict=True)
        ]
        wanted = [0.5 * (k == 1) for k in range(len(moments))]
        if not said and len(moments) > 2 and (table.order or 0) > 2 and len(rows) == len(c):
            said = [f"the dense output {name} has order 1: the sum of b_i(theta) c_i has {x:.3g} "
                    f"theta^{k}, not {y:g}" for k, (x, y) in
                    enumerate(zip(moments, wanted, strict=True), 1)
                    if abs(x - y) > method.coarse]  # fmt: skip
        remarks += said
        status = "question" if said and status in _GOOD else status
    return status


def _in_column(rows: Rows, k: int, gap: float, coarse: float) -> str:
    """Return which entry of a row of a dense output is off by a gap, as the sum of its column is.

    The columns sum to 1 (of theta) and 0.
    """
    sums = [complex(sum(vector(x), Exact(0))).real for x in zip(*rows, strict=True)]
    off = [j for j, x in enumerate(sums) if abs(x - (j == 0) - gap) <= coarse]
    if len(off) != 1:
        return ""
    x = rows[k][off[0]]
    is_, should = (f"{complex(x.value).real - y:.15g}" for y in (0, gap))
    return f": entry {off[0] + 1} of it is {is_} and should be {should}{_line([x])}"


def _unseen(table: Table, method: Trial) -> list[str]:
    """Return which rows of A nothing uses, so that no condition sees more of them than the sum."""
    if not table.general or table.kind != "rk" or len(table.b[0]) < 3:
        return []
    others = [vector(x) for x in (*table.errors, *(row for _, row, _ in table.rows))]
    found = []
    for k, row in enumerate(method.A[0]):
        used = any(len(x) <= k or complex(x[k]) != 0 for x in others)
        alike = all(abs(complex(x - y)) <= method.coarse
                    for x, y in zip(row, method.b[0], strict=True))  # fmt: skip
        if not used and not alike and enters_nothing(method, k):
            found.append(f"row {k + 1} of A enters nothing that is read: only its sum is checked")
    return found


def _alike(
    table: Table, library: Library, status: str, record: dict[str, Any], remarks: list[str]
) -> None:
    """Record the nearest method of the catalogue."""
    if table.kind in ("rk", "additive"):
        near = library.nearest(table, table.order or 0)
        if near:
            record["nearest"] = near
    if table.kind == "splitting" and status == "wrong":
        said = library.steps(table, table.order or 0)
        remarks += [said] if said else []
        swapped = replace(table, b=table.b[::-1])
        if re.search("drift|kick", table.source, re.IGNORECASE) and _holds(swapped):
            remarks.append(f"with the steps of drift and kick exchanged the order is {table.order}")


def _holds(table: Table) -> bool:
    """Return whether a table has the order that is declared."""
    method = Trial(table)
    return _reached(table, method).to(method.coarse) >= (table.order or 1)


def _stage(method: Trial, status: str, record: dict[str, Any], remarks: list[str]) -> str:
    """Ask about one stage whose abscissa is not the sum of its row, where the order holds.

    Where it is the sum to fewer digits than those of a double, the status is that of digits.
    """
    if status != "right" or method.gap <= 1e-12:
        return status
    if method.gap <= method.coarse:
        return "digits"
    k = method.gap_row
    if enters_nothing(method, k):
        remarks.append(f"stage {k + 1} has no weight: the next step or an estimate sees it alone")
        differing = beside_weights(method, k)
        if differing:
            record["correction"] = differing
        return "wrong" if differing or record.get("nearest", {}).get("entries") else "question"
    if one_row_apart(method):
        remarks.append("no other row does; the order holds on y' = f(t, y), too")
        return "question"
    return status


def _explained(
    table: Table,
    method: Trial,
    status: str,
    record: dict[str, Any],
    remarks: list[str],
    *,
    search: bool,
) -> str:
    """Look for what is wrong; a failure that nothing explains is a question."""
    if status != "wrong":
        return status
    entries = record.get("nearest", {}).get("entries")
    swapped = any("exchanged" in x or "embedded weights" in x for x in remarks)
    meant = any("declared" in x or "error" in x for x in remarks)
    if swapped and table.doubt and not (meant or entries):
        remarks.append(table.doubt)
        return "question"
    if table.order and not swapped and "tree" in record and record["found"] < table.order:
        look = correction if search else abscissa
        record["correction"] = look(method, table.order)
        if table.kind == "shu-osher" and not record["correction"]:
            record["correction"] = look(Trial(in_one_form(table)), table.order)
        if table.kind == "rk" and method.has_order(table.order, method.A[0][-1]):
            remarks.append(f"the last row of A as weights has order {table.order}")
    gaps = sum("differs from the sum" in x or "q''" in x for x in remarks)
    pair = _exchanged_nodes(method)
    if pair:
        i, j = pair[0] + 1, pair[1] + 1
        remarks.append(f"rows {i} and {j} of A sum to c[{j}] and c[{i}]: one pair is exchanged")
    if not (record.get("correction") or entries or len(remarks) > gaps):
        remarks.append(
            "the entries of a general linear method are not searched"
            if table.kind == "glm"
            else "no single entry explains it: the label, or more than one entry"
        )
        return "question"
    nameless = [x for x in record.get("correction", []) if x["is"] == "0"]
    if table.named and nameless:
        first = record.pop("correction")[0]
        remarks.append(f"{first['entry']} has no name in the code, and may be {first['should be']}")
        return "unread"
    return status


def _rows(table: Table, method: Trial, found: Reach, status: str, remarks: list[str]) -> str:
    fine, coarse = method.fine, method.coarse
    for label, weights, declared in table.rows:
        row = list(vector(weights))
        row += [Exact(0).ball()] * (len(method.b[0]) - len(row))
        if len(row) != len(method.b[0]):
            remarks.append(f"the row {label} has another length than b")
            continue
        least = declared or max(1, (table.order or 2) - 1)
        low = method.reached(least + 1, row)
        size, order = low.size(min(least, len(low.sizes))), low.to(coarse)
        if declared is not None and size > coarse:
            remarks.append(f"the row {label} is declared of order {declared} and has order {order}")
            remarks += mirrored(method, row, declared)
            status = "wrong"
        elif table.general and declared is None and order == 0:
            total = complex(sum(row, Exact(0))).real
            said = f"sums to {total:.9g}, not to 1"
            if abs(total) <= coarse:
                said = (
                    "sums to 0: it may be that of an error estimate, in place of embedded weights"
                )
            remarks.append(f"the row {label} {said}{_line(weights)}")
            one = one_weight(method, row, max(least, found.to(coarse) - 1))
            if one:
                k = int(one[0].split()[2])
                remarks[-1] = f"the row {label} {said}{_line(weights[k - 1 :])}"
            remarks += one
            meant = abs(total) <= coarse and re.search(r"hat|low|emb", label, re.IGNORECASE)
            status = "question" if status in ("right", "digits") or one or meant else status
        elif declared is not None and size > fine and size > 1e-12 * method.scale:
            remarks.append(f"the row {label} has order {declared} to {size:.1e}")
        elif table.general and declared is None and order < least and status in _GOOD:
            said = embedded(method, row, order, least)
            remarks += said
            status = "question" if said else status
        more = declared is None or order > declared  # than is said of this row
        least = max(found.to(coarse) + 1, table.order or 0 if found.to(coarse) == 0 else 0)
        if more and order >= least and table.order and found.to(coarse) < table.order:
            said = f", declared is {declared}" if declared is not None else ""
            pair = (declared, found.to(coarse), order) == (None, table.order - 1, table.order)
            beside = [x.name for x in table.block.items] if table.block else []
            own = table.block and table.block.kind == "record" and "order" in " ".join(beside)
            if pair and not own and table.general and table.kind == "rk" and not remarks:
                remarks.append(
                    f"the row {label} has the declared order, b one less: which propagates?"
                )
                status = "question"
                continue
            remarks.append(f"the row {label} has order {order}{said}: the rows may be exchanged")
    return status


def _line(row: Sequence[Any]) -> str:
    """Return where a row begins, as far as its reader noted it."""
    place = next((x.place for x in row if getattr(x, "place", None)), None)
    return f" (line {place[0]})" if place else ""


def summary(records: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """Count the records by status."""
    found: dict[str, int] = {}
    for x in records:
        found[x["status"]] = found.get(x["status"], 0) + 1
    return dict(sorted(found.items()))
