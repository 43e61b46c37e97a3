
function Nystrom4Tableau(::Type{T}, ::Type{T2}) where {T, T2}
    a = zeros(T, 3, 3)
    a[2, 1] = convert(T, 1 // 8)
    a[3, 2] = convert(T, 1 // 2)
    b = [convert(T, 1 // 6), convert(T, 2 // 6), zero(T)]
    bp = [convert(T, 1 // 6), convert(T, 4 // 6), convert(T, 1 // 6)]
    c = [convert(T2, 1 // 2), one(T2)]
    return NystromVITableau(a, b, bp, T[], T[], c, false, 2)
end
function NystromVITableau(a, b, bp)
    return NystromVITableau(a, b, bp, 1, 1, 1, 1)
end
