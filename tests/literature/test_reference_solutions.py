"""Reference states against other people's digits, and derived again in high precision.

The digits below marked "200 bits" come from another implementation, the Taylor integrator heyoka;
at 130 bits it gives the same, but for Hénon-Heiles at t = 1000. The others are printed in the
sources named.
"""

import json
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from glmref.catalogue.lookup import data_root
from glmref.conformance.taylor import taylor_states
from glmref.problems import names, problem
from glmref.problems.reference import Reference
from tools.collocation import collocation_states

# 200 bits: (problem, t) -> state
OTHER = {
    ("pendulum", 10): (
        "2.4685320486386486345943565674383694",
        "0.19609288936566895524738110551145283",
    ),
    ("pendulum", 100): (
        "-1.1556761142588505449913344336545527",
        "1.5520589882299573941424214082068961",
    ),
    ("henon-heiles", 10): (
        "-0.014151561495647997892573274890838512",
        "-0.25230779685949742777015921570236785",
        "-0.39727772040396749131833390560719104",
        "-0.13305700690478517311305250680770269",
    ),
    ("henon-heiles", 100): (
        "-0.4511586674131927887899560402588663",
        "-0.33752093547582099873572394908793281",
        "0.022024871506458001914421282464657442",
        "-0.20932635594812510940922834467758927",
    ),
    ("henon-heiles", 1000): (
        "0.53890865612403944640605819696756831",
        "-0.20436740886099521285668163288129478",
        "0.16910028986432598068119587916825567",
        "0.047243063397158599880727686860324066",
    ),
    ("double-pendulum", 10): (
        "0.75126574255482600541302677747445413",
        "0.80086913645126796504809206543032256",
        "-1.0475022319447214720034056020086131",
        "0.090794632700367373613360596270427184",
    ),
    ("fput-stiff", 10): (
        "1.0420576371025089543809652367346254",
        "0.24363557036319109581715138679575184",
        "-0.10636043796464912266284934084454084",
        "-0.027557931201251738303470193545051017",
        "-0.00059271779466757714680339960596369424",
        "0.00039505405961007551282274526382749629",
        "0.89732338905582560915498180892982648",
        "-0.61541755056678908695804268842873376",
        "-0.12870702707427070532308007323675804",
        "-0.11632415447804958424116865275942079",
        "0.22468371856386706002585036445937446",
        "0.0025490694862363960583465587744391437",
    ),
    ("outer-solar-system", 10000): (
        "0.053306088172255330725769772109038782",
        "-0.028052803944459498707379918755011519",
        "-0.013636778775970180208182357438888239",
        "4.7616886218133672697639231541341895",
        "-1.4985316562061406698336411543555875",
        "-0.758534323470254016421910185301067",
        "7.0843466396727544786978260431478279",
        "-6.3784134214123004670770448187146318",
        "-2.9393716783127347175967284326504108",
        "14.397421886207614069273832309579032",
        "12.442139480455788186501425234302638",
        "5.2450098068129851464594256471282957",
        "29.695174558793546020726311673729413",
        "-3.4839995619102973677182631626137578",
        "-2.166166688493879817999914872977007",
        "15.237592115586661724417160888326714",
        "-27.948052013040139605486961047020822",
        "-13.299424850200689483088739540638385",
        "0.0000029490091986445290934880138469869986",
        "-0.000010331859709797587339119964180601587",
        "-0.0000044911496849624322158550262996946881",
        "0.002405127021958639198836501275664965",
        "0.0068919700070138382012098412554525822",
        "0.0028955574706970728216056738319321929",
        "0.0036287986009553999998618926088195631",
        "0.0037002672586948817147761347796249906",
        "0.0013721335913607302569592595012075021",
        "-0.0027227654649196266538395009575306081",
        "0.0024352154342616161664276663660657416",
        "0.001104995974778242588659912861382981",
        "0.00040788663009527882264269128651259242",
        "0.0028979070606542931527866695267477148",
        "0.0011759029812950048215031405110586541",
        "0.0028998963899034051846668468076325415",
        "0.0010075184467679081847734684128957949",
        "-0.00055790581845189676005803135874782402",
    ),
    ("pleiades", 3): (
        "0.37061391439705129009395091772720843",
        "3.2372840920572330928033303905045902",
        "-3.222559032418323347100131467336129",
        "0.65970914557753083593499555576297005",
        "0.34255817071565797903773598109342932",
        "1.5621721014006310160457082117476333",
        "-0.70030929222124953851473267081897545",
        "-3.9434375855173920552778831715784855",
        "-3.2713809739725499280206768514720681",
        "5.2250818434565441924387381372119797",
        "-2.5906124349774695108111913570477652",
        "1.1982136933922746375140024105831919",
        "-0.24296823449358234091611163344418227",
        "1.0914492404289797478820636626895539",
        "3.4170038063143147522918925975057529",
        "1.3545845016255012214769819939813503",
        "-2.5900655978107754196186314413500028",
        "2.025053734714241106485013059898158",
        "-1.1558151001604490927119459150466685",
        "-0.80729881702230217256597207269762208",
        "0.59523963542087187666079250148685683",
        "-3.7412449612340084712047453961787188",
        "0.3773459685750629036558271160933428",
        "0.93868588695510788869468152616586274",
        "0.36679222272005698666964106862812452",
        "-0.34740463538084943660071653280620794",
        "2.3449154481809369231423171788827069",
        "-1.9470204342632919006742625854690364",
    ),
}


def high():
    context = mpmath.MPContext()
    context.dps = 60
    return context


def shipped(name, t, **parameters) -> Reference:
    """The reference of a problem at one time."""
    found = problem(name, **parameters).references
    return next(r for r in found if r.t == Fraction(t))


def difference(ours, theirs):
    """Largest difference relative to the largest component."""
    context = high()
    ours, theirs = [[context.mpf(x) for x in y] for y in (ours, theirs)]
    size = max(abs(x) for x in theirs)
    return max(abs(x - y) for x, y in zip(ours, theirs, strict=True)) / size


def body_by_body(state):
    """From the test set's order (all x, all y, all x', all y') to ours."""
    columns = np.array(state, dtype=object).reshape(2, 2, -1)
    return columns.transpose(0, 2, 1).reshape(-1).tolist()


def with_momenta(state):
    """Angles and angular velocities of the double pendulum to angles and momenta."""
    context = high()
    q1, q2, v1, v2 = [context.mpf(x) for x in state]
    c = context.cos(q1 - q2)
    return [q1, q2, 2 * v1 + v2 * c, v2 + v1 * c]


IN_OUR_COORDINATES = {"pleiades": body_by_body, "double-pendulum": with_momenta}


@pytest.mark.parametrize(("name", "t"), OTHER)
def test_references_agree_with_another_implementation_to_32_digits(name, t):
    theirs = IN_OUR_COORDINATES.get(name, list)(OTHER[name, t])
    # printed with 35 significant digits per component; chaos magnifies by 1e28 on the way to the
    # Hénon-Heiles state at t = 1000, of which 200 bits leave 32 digits (and 130 bits only 11)
    assert difference(shipped(name, t).state, theirs) < 1e-32


# name, parameters, t, digits as printed, relative difference that the printed digits allow, source
PRINTED = [
    (
        "pleiades",
        {},
        3,
        {0: ".3706139143970502", 2: "3.237284092057233", 4: "-3.222559032418324"},
        5e-15,
        "Test set, Pleiades: x1, x2, x3, which are components 0, 2, 4 body by body",
    ),
    (
        "van-der-pol",
        {},
        2,
        {0: "1.706167732170483", 1: "-0.8928097010247975"},
        3e-14,
        "Test set, release 2.4, Van der Pol (RADAU, quadruple precision)",
    ),
    (
        "robertson",
        {},
        10**11,
        {0: "2.083340149701255e-8", 1: "8.333360770334713e-14", 2: "0.9999999791665050"},
        2e-14,
        "Test set, release 2.4, Robertson",
    ),
    (
        "hires",
        {},
        "321.8122",
        {
            0: "7.371312573325668e-4",
            1: "1.442485726316185e-4",
            2: "5.888729740967575e-5",
            3: "1.175651343283149e-3",
            4: "2.386356198831331e-3",
            5: "6.238968252742796e-3",
            6: "2.849998395185769e-3",
            7: "2.850001604814231e-3",
        },
        1e-15,
        "Test set, release 2.4, HIRES (RADAU5, relative tolerance 1.1e-18)",
    ),
    (
        "oregonator",
        {},
        360,
        {0: "1.000814870318523", 1: "1228.178521549917", 2: "132.0554942846706"},
        2e-13,
        "deTestSet, Oregonator",
    ),
]


@pytest.mark.parametrize(("name", "parameters", "t", "printed", "allowed", "source"), PRINTED)
def test_references_agree_with_printed_digits(name, parameters, t, printed, allowed, source):
    ours = shipped(name, t, **parameters).state
    for i, digits in printed.items():
        assert difference([ours[i]], [digits]) < allowed


@pytest.mark.parametrize("orbit", [1, 2])
def test_arenstorf_orbits_close_as_far_as_their_printed_digits_go(orbit):
    p = problem("arenstorf", orbit=orbit)
    (reference,) = p.references
    start = p.on(high()).y0
    gap = difference(reference.state, start)
    # 29 digits of the speed, magnified by the orbit's instability of about 1e2 to 1e3
    assert 1e-30 < gap < 1e-24


def test_figure_eight_closes_to_its_eight_digits():
    p = problem("figure-eight")
    (reference,) = p.references
    assert 1e-9 < difference(reference.state, p.on(high()).y0) < 1e-6


@pytest.mark.parametrize("t", [10, 100])
def test_pendulum_references_agree_with_elliptic_functions(t):
    p = problem("pendulum")
    assert difference(shipped("pendulum", t).state, p.on(high()).solution(t)) < 1e-36


# every entry of every file: (problem, parameters, t), and the state
ENTRIES = [
    (path.stem, entry["parameters"], entry["t"], entry)
    for path in sorted((data_root() / "solutions").glob("*.json"))
    for entry in json.loads(path.read_text(encoding="utf-8"))["solutions"]
]


def test_what_has_no_closed_form_has_a_reference():
    listed = {name for name, *_ in ENTRIES}
    for name in names():
        free = name.startswith("fault") or name == "pythagorean"
        assert problem(name).exact or name in listed or free, name


@pytest.mark.parametrize(("name", "parameters", "t", "entry"), ENTRIES)
def test_problems_find_their_entries(name, parameters, t, entry):
    reference = shipped(name, t, **parameters)
    assert list(reference.state) == entry["state"] and reference.agreement < 1e-28
    assert len(reference.state) == problem(name, **parameters).dimension


@pytest.mark.parametrize(("name", "parameters", "t", "entry"), ENTRIES)
def test_invariants_at_the_references_are_those_of_the_start(name, parameters, t, entry):
    p, context = problem(name, **parameters), high()
    exact = p.on(context)
    end = np.array([context.mpf(x) for x in entry["state"]], dtype=object)
    for key, value in {**exact.invariants, **exact.quadratic, "H": exact.hamiltonian}.items():
        if value is not None:
            before, after = value(exact.y0), value(end)
            # stiff springs magnify an error in y by up to 1e4
            allowed = 1e6 * max(float(entry["agreement"]), 1e-38) * (1 + abs(before))
            assert abs(after - before) < allowed, (key, float(after - before))


QUICK = {("pendulum", "10"), ("henon-heiles", "10")}
STIFF = ("robertson", "hires", "van-der-pol", "oregonator")


def marked(cases, quick=()):
    """Cases with their own names, slow ones marked."""
    return [
        pytest.param(
            *case,
            marks=() if (case[0], case[2]) in quick else pytest.mark.slow,
            id=f"{case[0]}-{case[2][:8]}-{'-'.join(case[1].values())}",
        )
        for case in cases
    ]


@pytest.mark.sampled(len(QUICK), whole=18)
@pytest.mark.parametrize(("name", "parameters", "t", "entry"), marked(ENTRIES, QUICK))
def test_references_are_derived_again(name, parameters, t, entry):
    p = problem(name, **parameters)
    if name in STIFF:
        (end,) = collocation_states(p, [t], digits=14, stages=8)
        allowed = 1e-12
    else:
        # chaos takes 28 digits on the way to t = 1000
        (end,) = taylor_states(p, [t], digits=48 if t == "1000" else 22)
        allowed = 1e-15
    # steps are right to 1e-22 (1e-14 and better); the flow magnifies the sum of their errors
    assert difference(end, entry["state"]) < allowed


TWO_WAYS = ("arenstorf", "double-pendulum", "lotka-volterra", "nonseparable-chain", "rigid-body")
OTHERWISE = [case for case in ENTRIES if case[0] in TWO_WAYS]


@pytest.mark.sampled(0, whole=4)
@pytest.mark.parametrize(("name", "parameters", "t", "entry"), marked(OTHERWISE))
def test_taylor_states_are_derived_again_by_collocation(name, parameters, t, entry):
    (end,) = collocation_states(problem(name, **parameters), [t], digits=13, stages=8)
    # the highest coefficient of a step is 1e-13; the end of a step is right to its square nearly,
    # and the satellite's orbit magnifies by 1e3
    assert difference(end, entry["state"]) < 1e-11
