"""Conditions in which the residual of a model lies."""
