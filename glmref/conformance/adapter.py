"""What the suite asks of an integrator, how an adapter is found, and what its answers must be.

An adapter is any object with ``methods`` and ``step`` or ``solve``; see :class:`Adapter`. The
smallest one that passes::

    class Adapter:
        methods = ("rk4",)

        def step(self, method, problem, t, y, h):
            f = problem.f
            k1 = f(t, y)
            k2 = f(t + h / 2, y + h / 2 * k1)
            k3 = f(t + h / 2, y + h / 2 * k2)
            k4 = f(t + h, y + h * k3)
            return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from ..errors import UsageError, did_you_mean
from .subject import said

if TYPE_CHECKING:
    import numpy as np

    from ..problems import Problem


@dataclass(frozen=True)
class Shipped:
    """An adapter that comes with the package; its library is imported on first use."""

    place: str  #: Module of ``glmref.conformance.adapters`` and class.
    packages: str = ""  #: Packages of PyPI that it needs, in addition to glmref.
    system: str = ""  #: Packages of Debian that it needs.
    build: str = ""  #: Commands of a container recipe for what is no package.

    @property
    def target(self) -> str:
        """Module and class, as a user would write them."""
        return f"glmref.conformance.adapters.{self.place}"


_RKLIB = """\
ENV RKLIB=/rklib/src
RUN git clone --quiet https://github.com/jacobwilliams/roots-fortran /roots \\
 && git clone --quiet https://github.com/jacobwilliams/rklib /rklib && cd /rklib/src \\
 && gfortran -O1 -fPIC -cpp -c /roots/src/root_module.F90 rklib_module.F90 rklib_*_steps.f90 \\
    rklib_*_properties.f90 && ar rcs librklib.a *.o
"""
#: Adapters that come with the package.
SHIPPED: Mapping[str, Shipped] = {
    "reference": Shipped("reference:Adapter"),
    "compiled": Shipped("compiled:Adapter"),
    "scipy": Shipped("scipy_steps:Adapter", "scipy"),
    "diffrax": Shipped("diffrax_steps:Adapter", "diffrax"),
    "heyoka": Shipped("heyoka_taylor:Adapter", "heyoka"),
    "rebound": Shipped("rebound_leapfrog:Adapter", "rebound"),
    "nodepy": Shipped("nodepy_explicit:Adapter", "nodepy six sympy"),
    "extensisq": Shipped("extensisq_steps:Adapter", "extensisq"),
    "torchdiffeq": Shipped("torchdiffeq_steps:Adapter", "torchdiffeq"),
    "assimulo": Shipped("assimulo_steps:Adapter", "assimulo-testing"),
    "jitcode": Shipped("jitcode_steps:Adapter", "jitcode", "gcc libc6-dev"),
    "sundials": Shipped("sundials_steps:Adapter", system="gcc libc6-dev libsundials-dev"),
    "rklib": Shipped("rklib_steps:Adapter", system="gfortran git", build=_RKLIB),
    "gsl": Shipped("gsl_steps:Adapter", system="libgsl27"),
    "odeint": Shipped("odeint_steps:Adapter", system="g++ libboost-dev"),
    "exported-c": Shipped("exported:InC", system="gcc libc6-dev"),
    "exported-c++": Shipped("exported:InCpp", system="g++"),
    "exported-fortran": Shipped("exported:InFortran", system="gfortran"),
    "exported-julia": Shipped("exported:InJulia", "juliacall"),
    "exported-rust": Shipped("exported:InRust", system="rustc"),
    "exported-python": Shipped("exported:InPython"),
    "planted": Shipped("planted:Adapter"),
}


class Adapter(Protocol):
    """An integrator under test. Only ``methods`` and one of ``step`` and ``solve`` are required.

    Everywhere ``method`` is a name out of ``methods`` and ``problem`` a
    :class:`glmref.Problem`: ``problem.f(t, y)`` is the right-hand side, shape (d,) in and out,
    ``problem.jacobian(t, y)`` its derivative, ``problem.y0`` and ``problem.t_span[0]`` where
    ``solve`` and ``start`` begin. Where ``problem.separable``, y = (q, p) with ``problem.dq(p)``
    and ``problem.dp(q)`` the two halves of f, and d is even.

    ``y`` is the array of the values carried, in the basis of the method's data file: (r, d), or
    (d,) for a method that carries one value. It must not be changed.

    Attributes
    ----------
    methods : Sequence[str] or Mapping[str, Mapping[str, object]]
        Names of ``glmref list`` (or paths of method files) this integrator claims to be; or a
        mapping ``name -> {"order": p, "symmetric": True, "symplectic": True}`` for one the
        catalogue lacks: then only these claims, if made, are measured.
    epsilon
        Unit round-off of the arithmetic; 2**-53 by default.
    tolerance
        Relative error with which stage equations are solved, or a mapping from methods to it; 1e-14
        by default.
    problems
        Names of the only problems it can do; all by default.
    starts
        ``"file"`` (the default) when ``solve`` starts as the method's data say, ``"own"`` when it
        makes its own starting values, so that only the end of a run can be judged.
    """

    methods: Sequence[str] | Mapping[str, Mapping[str, object]]

    def step(self, method: str, problem: Problem, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Return the values after one step of size h, which may be negative."""
        ...

    def solve(self, method: str, problem: Problem, h: float, steps: int) -> np.ndarray:
        """Start at ``problem.y0``, take steps, finish each: shape (steps + 1, d) or (d,), the end.

        A method whose data give no starting method gets ``start``, the values (r, d), as a keyword.
        """
        ...

    def stages(
        self, method: str, problem: Problem, t: float, y: np.ndarray, h: float
    ) -> np.ndarray:
        """Return the stage values (s, d) of a step, of a pair (Q, P) two arrays (optional)."""
        ...

    def start(self, method: str, problem: Problem, h: float) -> np.ndarray:
        """Return the starting values (r, d) from ``problem.y0`` (optional)."""
        ...

    def finish(
        self, method: str, problem: Problem, t: float, y: np.ndarray, h: float
    ) -> np.ndarray:
        """Return the solution (d,) that belongs to the values (optional)."""
        ...


def load_adapter(text: str) -> Any:
    """Find the adapter a user names.

    ``text`` is ``package.module:Name`` (a class is called without arguments), the name of a shipped
    adapter, or ``cmd:program argument ...``.

    Raises
    ------
    UsageError
        One sentence on what is wrong and what to do.
    """
    if text in SHIPPED:
        text = SHIPPED[text].target
    if text.startswith("cmd:"):
        from .pipe import PipeAdapter

        return PipeAdapter(text.removeprefix("cmd:"))
    place, colon, name = text.partition(":")
    if not colon or not place or not name:
        raise UsageError(
            f"the adapter must be written package.module:Name, cmd:program, or one of "
            f"{', '.join(SHIPPED)}; got {text!r}{did_you_mean(text, SHIPPED, '; ')}"
        )
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())  # plain pytest leaves it out
    try:
        value: Any = import_module(place)
    except (Exception, SystemExit) as error:
        if place.endswith(".py"):
            raise UsageError(
                f"the adapter must name a module, not a file: write "
                f"{place.removesuffix('.py').replace('/', '.')}:{name}"
            ) from None
        raise UsageError(
            f"the adapter's module {place!r} cannot be imported ({said(error)})"
        ) from None
    for part in name.split("."):
        if not hasattr(value, part):
            raise UsageError(f"the module {place!r} has no {name!r}; the adapter must be there")
        value = getattr(value, part)
    if isinstance(value, type) or (callable(value) and not hasattr(value, "methods")):
        try:
            value = value()
        except (Exception, SystemExit) as error:
            raise UsageError(
                f"the adapter {text!r} cannot be made without arguments ({said(error)})"
            ) from None
    return value
