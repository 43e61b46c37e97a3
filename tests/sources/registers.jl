# Runge-Kutta methods with few registers
function two_n()
    order = 3
    a = SVector(0.0, 5 / 9, 153 / 128)
    b = SVector(1 / 3, 15 / 16, 8 / 15)
    c = SVector(0.0, 1 / 3, 3 / 4)
    return new(a, b, c)
end
function two_r()
    order = 3
    a = SVector(0.0, 8 / 15, 5 / 12)
    b = SVector(1 / 4, 0, 3 / 4)
    c = SVector(0.0, a[2], b[1] + a[3])
    return new(a, b, c)
end
