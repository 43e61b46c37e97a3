"""Methods and results as text, tables and pictures; nothing here computes a verdict."""
