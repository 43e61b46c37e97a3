
    module procedure heun
    real(wp),parameter :: half = 1.0_wp / 2.0_wp
    associate (f1 => me%funcs(:,1), &
               f2 => me%funcs(:,2))
        call me%f(t,x,f1)          ! the first
        call me%f(t+h, x+h*f1, f2)
        xf = x + h*half*(f1 + &
             f2)
        xerr = h*(half*f2 - half*f1)
    end associate
    end procedure heun
    module procedure heun_properties
        p%order = 2
    end procedure heun_properties
