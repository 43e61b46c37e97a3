// one integrator of several orders
void Variable::Choose(int order)
{
   order_ = order;
   switch (order_)
   {
      case 2:
         a_[0] = 0.5; a_[1] = 0.5;
         b_[0] = 0.0; b_[1] = 1.0;
         break;
      case 3:
         a_[0] = 2.0/3.0; a_[1] = -2.0/3.0; a_[2] = 1.0;
         b_[0] = 7.0/24.0; b_[1] = 0.75; b_[2] = -1.0/24.0;
         break;
   }
}
