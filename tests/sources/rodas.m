% Rosenbrock method with 3 stages
function [A, Gamma, b, order] = ros3p()
  order = 3;
  g = 7.886751345948129e-01;
  A = [0 0 0
       1 0 0
       1 0 0];
  Gamma = [g 0 0
           -1 g 0
           -g 1/2-2*g g];
  b = [2/3 0 1/3];
end
