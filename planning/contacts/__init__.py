"""Where to hold: branch and bound over contacts with multipliers as bounds, and what holding elsewhere costs."""
