"""Numbers as printed: one file per source."""
