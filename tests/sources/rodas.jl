
const ROSA = [
    0 0
    1.2 0
]
const ROSC = [
    0
    -1.0
]
function Two2Tableau(::Type{T}, ::Type{T2}) where {T, T2}
    gamma = inv(convert(T2, 2))
    s = size(ROSA, 1)
    b = T[ROSA[s, i] for i in 1:(s - 1)]
    push!(b, one(T))
    btilde = nothing
    return RodasTableau{T, T2, Vector{T}}(ROSA, ROSC, gamma, 0, 0, 0, b, btilde)
end
