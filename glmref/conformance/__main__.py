"""``python -m glmref.conformance ADAPTER`` is ``glmref conformance ADAPTER``."""

import runpy
import sys

if __name__ == "__main__":
    sys.argv[1:1] = ["conformance"]
    runpy.run_module("glmref", run_name="__main__", alter_sys=True)
