# An author of an integrator in C: compile it, see the checks, make them, see a defect named.
# `docs/ways/rk4.c` answers the suite on stdin and stdout; with `slip` two weights are exchanged.
cc -O2 -o rk4 docs/ways/rk4.c
glmref conformance cmd:./rk4 --list
glmref conformance cmd:./rk4
glmref conformance "cmd:./rk4 slip" || echo "exit code $?: the defect is named above"
glmref conformance cmd:./rk4 --identify
