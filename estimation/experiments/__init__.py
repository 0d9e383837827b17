"""Which motion to record next, so that what is still open of a cart shows."""
