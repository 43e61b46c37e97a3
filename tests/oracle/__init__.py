"""A second opinion on claims, by definition and numerically; it shares no code with glmref."""
