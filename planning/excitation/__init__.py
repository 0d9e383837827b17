"""Contacts and a small weave that teach most for an allowed effort."""
