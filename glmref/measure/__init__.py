"""What is measured: convergence, long runs, parasitic growth, work-precision, stability."""
