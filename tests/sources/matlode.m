function [ erkMethod erkS ] = Coefficients_Heun( RK2 )
% rkA(2,1) = 7;
    global rkA rkB rkC rkE
    rkA(2,1) = 1.0d0;
    rkB(1,1) = 1/2;
    rkB(1,2) = 1/2;
    rkC(2) = 1.0;
    rkE(1) = 1.0;
    rkE(2) = 0.0;
return;
