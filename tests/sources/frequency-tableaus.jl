
struct Made2ConstantCache{T} <: Cache
    a21::T
end
alg_order(alg::Made2) = 2
function Made2ConstantCache(T, T2)
    a21 = convert(T, 1 // 2)
    b1 = convert(T, 0)
    b2 = convert(T, 1)
    c2 = convert(T2, 1 // 2)
    return Made2ConstantCache(a21, b1, b2, c2)
end
