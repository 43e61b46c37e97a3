
@muladd function perform_step!(integrator, cache::Made2ConstantCache, repeat_step = false)
    (; t, dt, uprev, u, f, p) = integrator
    (; a21, b1, b2, c2) = cache
    v = alg.w * dt
    a21 += v^2
    k1 = integrator.fsalfirst
end

function perform_step!(integrator, cache::Other2ConstantCache, repeat_step = false)
    (; a21, c2) = cache
    k2 = f(uprev + dt * a21 * k1, p, t + c2 * dt)
    if a21 == c2
        u = k2
    end
end
