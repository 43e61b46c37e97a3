
"""
    Kutta3()

Kutta's method; `A[1, 2] = 7` in a text means nothing.
"""
function Kutta3(::Type{T} = Float64, ::Type{T_time} = T) where {T, T_time}
    t = 2 * big"0.25"
    A = [
        0 0 0
        1 // 2 0 0
        -1 4t 0
    ]
    c = [0; 1 // 2; 1]
    α = [1 // 6; 2 // 3; 1 // 6]
    αEEst = [0, 1, 0]
    A = map(T, A)
    return (
        DiffEqBase.ExplicitRKTableau(
            A, c, α, 3; αEEst, adaptiveorder = 2,
            stability_size = 2.5127453266183286
        )
    )
end

struct Nothing{T}
    x::T
end

"""
    Cooper2()

A second-order method whose entry 1/2 is misprinted.
"""
struct Cooper2 <: DIRK{2} end
function RKTableau(alg::Cooper2, RealT)
    n = 2
    a = zeros(RealT, n, n)
    a[2, 1] = 2 // 3
    b = a[2, :]
    b[1] = 0
    b[2] = 1
    return DIRKButcher(a, b, zeros(RealT, n))
end

function TableauX(::Type{T}=Float64) where {T}
    a = @big [[ 0     0    ]
              [ 1//2  0    ]]
    b = @big  [ 0,    1    ]
    c = @big  [ 0,    1//3 ]
    o = 2
    Tableau{T}(:Midpoint, o, a, b, c)
end

function IMEXTableau(::ARS222)
    γ = 1 - √2 / 2
    δ = 1 - 1 / 2γ  # which is 1 / (2γ)
    IMEXTableau(;
        a_exp = @SArray([
            0 0 0
            γ 0 0
            δ (1-δ) 0
        ]),
        b_exp = @SArray([0, 1 - γ, γ]),
        a_imp = @SArray([
            0 0 0
            0 γ 0
            0 (1-γ) γ
        ])
    )
end

function HeunConstantCache(T, T2)
    a21 = convert(T, 1)
    b1 = convert(T, 1 // 2)
    b2 = convert(T, 1 // 2)
    btilde1 = convert(T, -1 // 2)
    btilde2 = convert(T, 1 // 4)
    c2 = convert(T2, 1)
    return HeunConstantCache(a21, b1, b2, btilde1, btilde2, c2)
end

function LeapfrogConstantCache(T, T2)
    a1 = convert(T, 1 // 2)
    a2 = convert(T, 1 // 2)
    b1 = convert(T, 1)
    b2 = convert(T, 0)
    return SymplecticTableau((a1, a2), (b1, b2))
end
