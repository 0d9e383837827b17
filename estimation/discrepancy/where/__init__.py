"""In which conditions the residual of a model lies."""
