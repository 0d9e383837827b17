"""What of a search holds on unseen stretches, how sure it is, and by which names it goes."""
