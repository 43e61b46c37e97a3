"""Steppers of Boost.odeint, compiled around a function with the interface of C."""

from __future__ import annotations

from .foreign import CPP, Built

_SOURCE = CPP.format(
    includes="#include <boost/numeric/odeint/stepper/STEPPER.hpp>",
    steps="""
    const auto g = [&](const Vector &x, Vector &k, double s) { f(s, x.data(), k.data(), data); };
    Vector x(y, y + d);
    for (long n = 0; n < steps; n++) {
      boost::numeric::odeint::STEPPER<Vector> stepper;  // no slope is kept from step to step
      stepper.do_step(g, x, t + n * h, h);
    }
    std::copy(x.begin(), x.end(), y);""",
)
#: Name in the catalogue -> class of odeint.
STEPPERS = {
    "rk4": "runge_kutta4",
    "cash-karp-5": "runge_kutta_cash_karp54",
    "dormand-prince-5": "runge_kutta_dopri5",
    "rkf78-8": "runge_kutta_fehlberg78",
}


class Adapter(Built):
    """``boost::numeric::odeint``: four explicit Runge-Kutta methods."""

    compiler = ("g++", "-std=c++14", "-O1", "-w", "-shared", "-fPIC")
    methods = tuple(STEPPERS)

    def __init__(self) -> None:
        super().__init__(
            {name: {"run.cpp": _SOURCE.replace("STEPPER", kind)} for name, kind in STEPPERS.items()}
        )
