
class pair : public explicit_error_stepper_fsal_base< pair< State , Value > , 2 , 2 , 1 , State >
{
    const value_type b21 = static_cast<value_type>( 1 );
    const value_type c1 = static_cast<value_type>( 1 ) / static_cast<value_type>( 2 );
    const value_type c2 = static_cast<value_type>( 1 ) / static_cast<value_type>( 2 );
    const value_type dc1 = c1 - static_cast<value_type>( 1 ) / static_cast<value_type>( 4 );
    const value_type dc2 = static_cast<value_type>( 0 );
    const value_type dc3 = static_cast<value_type>( -1 ) / static_cast<value_type>( 4 );
};
