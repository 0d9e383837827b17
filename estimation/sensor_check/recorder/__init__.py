"""What recorders and trackers do to a column: rows written again, steps, jumps, gaps."""
