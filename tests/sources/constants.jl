
function Euler2ConstantCache(T, T1)
    a0100 = convert(T, 1)
    b1 = T1(1 // 2)
    b2 = T1(1 // 2)
    c1 = T1(1)
    return Euler2ConstantCache(a0100, b1, b2, c1)
end
function IRKN3ConstantCache(T::Type, T2::Type)
    a21 = convert(T, 1 // 8)
    bbar1 = convert(T, 1 // 3)
    return IRKN3ConstantCache(a21, bbar1, 1)
end
function SRA2ConstantCache(T::Type, T2::Type)
    a21 = convert(T, 3 // 4)
    α1 = convert(T, 1 // 3)
    return SRA2ConstantCache(a21, α1, 1)
end
