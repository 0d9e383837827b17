"""A problem file: strict, with exact places."""
