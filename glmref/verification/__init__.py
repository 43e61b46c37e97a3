"""What a data file claims, recomputed; and what a method is when nothing is claimed."""
