# Kepler's problem, e = 0.2, with the exported stepper in stepper.jl; its module is the third argument.
include("stepper.jl")
const M = getfield(Main, Symbol(ARGS[3]))
force(q) = -q[1:2] ./ sqrt(q[1]^2 + q[2]^2)^3
h, steps = parse(Float64, ARGS[1]), parse(Int, ARGS[2])
if length(ARGS) > 3
    q, p = M.integrate(identity, force, h, steps, [0.8, 0.0], [0.0, sqrt(1.5)])
    y = [q; p]
else
    f(t, y) = [y[3:4]; force(y)]
    y = M.integrate(f, 0.0, h, steps, [0.8, 0.0, 0.0, sqrt(1.5)])
end
println(join(y, " "))
