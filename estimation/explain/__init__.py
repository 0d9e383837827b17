"""Finds what a cart's model lacks (being rebuilt)."""
