"""Explicit tables of ARKODE in SUNDIALS, at constant step size, around a function of C."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from .foreign import Built

_SOURCE = """
#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#if SUNDIALS_VERSION_MAJOR < 7
#define SUN_COMM_NULL NULL
#endif
typedef void (*rhs)(double, const double *, double *, void *);
typedef struct { rhs f; void *data; } Given;
static int slope(double t, N_Vector y, N_Vector out, void *given) {
  Given *g = given;
  g->f(t, N_VGetArrayPointer(y), N_VGetArrayPointer(out), g->data);
  return 0;
}
int run(rhs f, void *data, int d, double t, double h, long steps, double *y) {
  Given given = {f, data};
  SUNContext context;
  double reached = t;
  int failed = SUNContext_Create(SUN_COMM_NULL, &context);
  if (failed) return failed;
  N_Vector state = N_VMake_Serial(d, y, context);
  void *memory = ERKStepCreate(slope, t, state, context);
  failed = ERKStepSetUserData(memory, &given) || ERKStepSetTableNum(memory, ARKODE_TABLE) ||
           ERKStepSetFixedStep(memory, h) || ERKStepSetMaxNumSteps(memory, steps + 1);
  for (long n = 0; !failed && n < steps; n++)
    failed = ERKStepEvolve(memory, t + steps * h, state, &reached, ARK_ONE_STEP) < 0;
  ERKStepFree(&memory);
  N_VDestroy(state);
  SUNContext_Free(&context);
  return failed;
}
"""
#: Name in the catalogue, or what is claimed -> table of ARKODE.
TABLES = {
    "heun-2": "HEUN_EULER_2_1_2",
    "bogacki-shampine-3": "BOGACKI_SHAMPINE_4_2_3",
    "cash-karp-5": "CASH_KARP_6_4_5",
    "rkf45-5": "FEHLBERG_6_4_5",
    "dormand-prince-5": "DORMAND_PRINCE_7_4_5",
    "rkf78-8": "FEHLBERG_13_7_8",
    "knoth-wolke": "KNOTH_WOLKE_3_3",
    "zonneveld": "ZONNEVELD_5_3_4",
    "sayfy-aburub": "SAYFY_ABURUB_6_3_4",
    "verner": "VERNER_8_5_6",
}


class Adapter(Built):
    """``ERKStep`` of ARKODE: ten explicit Runge-Kutta methods."""

    compiler = ("gcc", "-std=c99", "-O1", "-shared", "-fPIC")
    libraries = ("-lsundials_arkode", "-lsundials_nvecserial", "-lm")
    methods: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        name: {} if name[-1].isdigit() else {"order": int(table[-1])}
        for name, table in TABLES.items()
    }

    def __init__(self) -> None:
        super().__init__(
            {name: {"run.c": _SOURCE.replace("TABLE", table)} for name, table in TABLES.items()}
        )
