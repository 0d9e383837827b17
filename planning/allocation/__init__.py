"""A desired wrench spread over the arms at given contacts, and what can't be done, by how much."""
