"""The records of the audit hold the known defects, and the pages say how many there are."""

import json
import re
from pathlib import Path

import pytest

from campaigns.audited_codes import PAGE, SHORT, without
from glmref.audit.lexer import LANGUAGES
from glmref.audit.recognising import tables
from glmref.audit.table_verdicts import judge
from glmref.catalogue.audits import STATUSES, audited_codes, named

RECORDS = audited_codes()
#: Tables that a first reading by hand found wrong or oddly named, and what the audit names.
KNOWN = json.loads(Path(__file__).with_name("known_defects.json").read_text("utf-8"))


def test_the_counts_in_the_sentence_are_those_of_the_records() -> None:
    n = {x: sum(r["counts"].get(x, 0) for r in RECORDS.values()) for x in STATUSES}
    codes = sum(1 for x in RECORDS.values() if x["tables"])
    said = (
        f"Of {sum(n.values())} tables in {codes} codes {n['right']} are right, {n['digits']} "
        f"right to fewer digits, {n['wrong']} wrong, and {n['question']} a question; {n['found']} "
        f"declare no order, and {n['unread']} could not be read. Several of the {n['wrong']} wrong"
    )
    assert said in " ".join(SHORT.read_text("utf-8").split())


@pytest.mark.parametrize(("code", "name", "status", "said"), KNOWN, ids=[x[1] for x in KNOWN])
def test_a_known_defect_is_found_with_its_entry(
    code: str, name: str, status: str, said: str
) -> None:
    found = [x for x in RECORDS[code]["tables"] if x["name"] == name and x["status"] == status]
    assert found and said in named(found[0])
    assert "\n" not in named(found[0])


@pytest.mark.parametrize("code", ["sundials", "rklib", "gsl", "scipy"])
def test_a_code_without_a_defect_has_no_wrong_table(code: str) -> None:
    assert "wrong" not in RECORDS[code]["counts"]


def test_a_code_without_a_table_says_how_many_files_were_read() -> None:
    assert all((x["files"] > 0) != bool(x["tables"]) for x in RECORDS.values() if "files" in x)
    assert all(x["tables"] or "files" in x for x in RECORDS.values())
    assert re.search(r"\[petar\]\(\S+\) \(47\)", without())


def test_the_one_wrong_method_of_principia_has_a_row_that_is_not_c() -> None:
    """-243/128 with its digits exchanged; no other table of that code is called wrong."""
    wrong = [x["name"] for x in RECORDS["principia"]["tables"] if x["status"] == "wrong"]
    assert {x.partition(",")[0] for x in wrong} == {"Fine1987RKNG34"}


#: Lambert65 in nodepy/runge_kutta_method.py (0f071ac, line 2937): its alpha, and beta where right.
LAMBERT = """
one = 1
zero = 0
alpha=snp.zeros([7,6])
beta=snp.zeros([7,6])
alpha[1,0]=one
alpha[2,0:2]=[3*one/4,1*one/4]
alpha[3,0:3]=[3*one/8,1*one/8,1*one/2]
alpha[4,0:4]=[1*one/4,1*one/8,1*one/8,1*one/2]
alpha[5,0:5]=[89537*one/2880000,407023*one/2880000,1511*one/12000,87*one/200,4*one/15]
alpha[6,:]=[4*one/9,1*one/15,zero,8*one/45,zero,14*one/45]
beta[1,0]=1*one/2
beta[6,:]=[zero,-8*one/45,zero,2*one/3,zero,7*one/90]
"""


@pytest.mark.parametrize("page", [PAGE, PAGE.parent / "nodepy.md"], ids=["page", "letter"])
def test_the_rows_of_beta_that_are_printed_give_lambert65_its_order(page) -> None:
    rows = re.findall(r"^ *(beta\[[2-5],.*)$", page.read_text("utf-8"), re.M)
    assert len(rows) == 4
    made = "RK['Lambert65']=ExplicitRungeKuttaMethod(alpha=alpha,beta=beta,name='Lambert')"
    text = "\n".join(["# Runge-Kutta", LAMBERT, *rows, made, ""])
    (table,) = tables(text, LANGUAGES["python"])
    found = judge(table)
    assert (found["declared"], found["found"], found["status"]) == (5, 5, "right")


def test_the_weights_that_are_printed_for_thermostats_have_order_4() -> None:
    letter = (PAGE.parent / "gromacs-openmm-jax-md.md").read_text("utf-8")
    lists = re.findall(r"^ +[35]: +(.*)$", letter, re.M)
    text = "// Suzuki\n" + "\n".join(f"double w{len(x)}[] = {{{x}}};" for x in lists)
    assert [judge(x)["found"] for x in tables(text, LANGUAGES["c"])] == [4, 4]
