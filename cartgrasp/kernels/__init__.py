"""The physics of carts as scalar code, compiled by numba: each effect's formula and partials stand here and nowhere
else. Nothing here is imported before a model is first evaluated, and nothing here imports the classes."""
