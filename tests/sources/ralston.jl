using StaticArrays
# Runge-Kutta coefficients
struct Method{N, T}
    A::SMatrix{N, N, T}
    b::SVector{N, T}
    c::SVector{N, T}
    order::Int
end
const KUTTA38 = Method(
    SMatrix{4, 4}([0 0 0 0; 1//3 0 0 0; -1//3 1 0 0; 1 -1 1 0]),
    SVector(1//8, 3//8, 3//8, 1//8),
    SVector(0, 1//3, 2//3, 1), 4)
