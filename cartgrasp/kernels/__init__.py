"""The physics of carts as scalar code, compiled by numba: each effect's formula and partials stand here and nowhere
else. Nothing here is imported before a model is first evaluated, and nothing here imports the classes.

`entries.py` is the door, for Python and for kernels of other packages alike: its functions take C-contiguous arrays of
float64 (and the int64 of a workspace), write into the last one and return no array. The kernels behind it count no
references, so code that does may not call them: what they return would be freed twice. With `dynamics = cart.dynamics`,
a kernel of an estimator calls

    inverses(dynamics.floats, dynamics.ints, given, found)

with rows (b, n + 1 + p + f) of state | time | parameters | nu' `given`, and rows
(b, f (1 + n + f + p) + k (1 + n + p)) to be `found`: reduced wrench (f,) | by state (f, n) | by nu' (f, f) |
by parameters (f, p) | memory's rate (k,) | by state (k, n) | by parameters (k, p), as in `CartModel.inverse`.
It is kept for the next process under a name that holds `jit.DIGEST` beside a digest of its own sources
(`compiling.cached_as`).

`docs/extending.md` lists what a new effect takes.
"""
