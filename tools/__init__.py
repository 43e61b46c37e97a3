"""What makes shipped reference data once."""
