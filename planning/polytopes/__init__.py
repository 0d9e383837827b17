"""All that an arm can give at a posture, and how much of a push."""
