"""The methods of order 6 and 8: compared, run for long, started."""
