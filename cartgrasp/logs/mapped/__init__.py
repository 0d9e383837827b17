"""What maps of bags and of tables have in common: from samples of several clocks to a run log."""
