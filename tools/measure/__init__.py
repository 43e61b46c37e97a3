"""Measurements behind pages of the documentation that are no scenes: against C, against others."""
