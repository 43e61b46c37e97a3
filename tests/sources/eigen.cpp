
namespace space
{
void initializeHeunCoefficients( Coefficients& h )
{
    h.lowerOrder = 1;
    h.higherOrder = 2;
    h.aCoefficients = Eigen::MatrixXd::Zero( 2, 2 );
    h.aCoefficients( 1, 0 ) = 1.0;
    h.cCoefficients = Eigen::VectorXd::Zero( 2 );
    h.cCoefficients( 1 ) = 1.0;
    h.bCoefficients = Eigen::MatrixXd::Zero( 2, 2 );
    h.bCoefficients( 0, 0 ) = 1.0;
    h.bCoefficients( 1, 0 ) = 1.0 / 2.0;
    h.bCoefficients( 1, 1 ) = 1.0 / 2.0;
}
}
