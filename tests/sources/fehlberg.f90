! Runge-Kutta-Fehlberg, order = 4
module coefs
  implicit none
  integer, parameter :: order = 4
  real(8), dimension(5,5) :: a
  real(8), parameter :: b(5) = (/ 25.d0/216.d0, 0.d0, 1408.d0/2565.d0, 2197.d0/4104.d0, &
                                  -1.d0/5.d0 /)
  real(8), parameter :: c(5) = (/ 0.d0, 0.25d0, 0.375d0, 12.d0/13.d0, 1.d0 /)
  data a(2,1) / 0.25d0 /
  data a(3,1), a(3,2) / 0.09375d0, 0.28125d0 /
  data a(4,1), a(4,2), a(4,3) / 0.87938097405553026d0, -3.2771961766044606d0, 3.3208921256258535d0 /
  data a(5,1), a(5,2), a(5,3), a(5,4) / 2.0324074074074074d0, -8.d0, 7.1734892787524366d0, &
       -0.20589668615984405d0 /
end module
