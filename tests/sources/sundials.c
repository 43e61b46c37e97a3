
ARK_BUTCHER_TABLE(ARKODE_HEUN_EULER_2_1_2, { /* Heun-Euler-ERK */
    ARKodeButcherTable B = ARKodeButcherTable_Alloc(2, SUNTRUE);
    B->q = 2;
    B->p = 1;
    B->A[1][0] = SUN_RCONST(1.0);
    B->b[0] = SUN_RCONST(1.0)/SUN_RCONST(2.0);
    B->b[1] = SUN_RCONST(1.0)/SUN_RCONST(2.0);
    B->d[0] = SUN_RCONST(1.0);
    B->c[1] = SUN_RCONST(1.0);
    return B;
 })
ARK_BUTCHER_TABLE(ARKODE_MADE_UP, {
    ARKodeButcherTable B = ARKodeButcherTable_Alloc(1, SUNFALSE);
    B->q = 1;
    B->b[0] = magic(3);
    return B;
 })
