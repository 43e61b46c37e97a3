! Kepler's problem, e = 0.2, with an exported stepper: NAME is its module, PAIR for pairs.
program main
  use NAME, only: integrate, done
  implicit none
  integer, parameter :: real64 = kind(1d0)
  character(32) :: word
  real(real64) :: h, y(4)
#ifdef PAIR
  real(real64) :: x(2, 2)
#else
  real(real64) :: x(4, 1)
#endif
  integer :: steps, status
  call get_command_argument(1, word)
  read (word, *) h
  call get_command_argument(2, word)
  read (word, *) steps
  y = [0.8_real64, 0._real64, 0._real64, sqrt(1.5_real64)]
  x = reshape(y, shape(x))
#ifdef PAIR
  call integrate(dq, dp, h, steps, x, status)
#else
  call integrate(f, 0._real64, h, steps, x, status)
#endif
  if (status /= done) error stop 1
  write (*, '(4es26.17e3)') x
contains
#ifdef PAIR
  subroutine dq(x, slope)
    real(real64), intent(in) :: x(:)
    real(real64), intent(out) :: slope(:)
    slope = x
  end subroutine
  subroutine dp(x, slope)
    real(real64), intent(in) :: x(:)
    real(real64), intent(out) :: slope(:)
    slope = -x / sqrt(x(1)**2 + x(2)**2)**3
  end subroutine
#else
  subroutine f(t, y, slope)
    real(real64), intent(in) :: t, y(:)
    real(real64), intent(out) :: slope(:)
    slope = [y(3:4), -y(1:2) / sqrt(y(1)**2 + y(2)**2)**3] + 0 * t
  end subroutine
#endif
end program
