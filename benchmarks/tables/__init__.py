"""Made tables of strangers' kinds: how many `cartgrasp topics` reads right, and which wrongly in silence."""
