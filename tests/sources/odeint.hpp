
template< class Value = double >
struct mid_coefficients_a1 : std::array< Value , 1 >
{
    mid_coefficients_a1( void )
    {
        (*this)[0] = static_cast< Value >( 1 ) / static_cast< Value >( 2 );
    }
};
struct mid_coefficients_b : std::array< Value , 2 >
{
    mid_coefficients_b( void )
    {
        (*this)[0] = static_cast< Value >( 0 );
        (*this)[1] = static_cast< Value >( 1 );
    }
};
struct mid_coefficients_c : std::array< Value , 2 >
{
    mid_coefficients_c( void )
    {
        (*this)[0] = static_cast< Value >( 0 );
        (*this)[1] = static_cast< Value >( 1 ) / static_cast< Value >( 2 );
    }
};
template<
class State ,
class Value = double
>
class midpoint : public explicit_generic_rk< 2 , 2 , State , Value >
{
};
