"""When and where to regrasp over a horizon, by dynamic programming."""
