
/* a21 = 7; */
const scalar
    Heun::c2 = 1.0,
    Heun::a21 = 1.0,
    Heun::b1 = 0.5,
    Heun::b2 = 1.0 - Heun::b1,
    Heun::e1 = 1.0 - 0.5,
    Heun::e2 = -0.5;
}
