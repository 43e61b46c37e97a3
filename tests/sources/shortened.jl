
function Shortened4ConstantCache(T::Type, T2::Type)
    a1 = convert(T, big"0.40518861839525227722")
    a2 = convert(T, big"-0.28714404081652408900")
    a3 = 1 - 2a1 - 2a2
    b1 = convert(T, -3 // 73)
    b2 = convert(T, 17 // 59)
    b3 = 1 - 2b1 - 2b2
    return SymplecticTableau((a1, a2, a3, a2, a1), (b1, b2, b3, b2, b1))
end
