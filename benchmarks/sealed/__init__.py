"""A sealed benchmark of the discrepancy workflow: run logs of carts with hidden effects, and a score.

The generator shares no code with the package that it tests. It has its own equations and, where the real world
differs from the vocabulary, other functional forms. Truth goes to a folder of its own, logs have opaque names.
"""
