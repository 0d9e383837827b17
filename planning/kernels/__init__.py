"""What runs at controller rate, compiled by numba. Nothing here is imported before a planner's `warm_up`.

A kernel that mirrors numpy code says so in its head: proof.py (`quadratic_program.verify`, `duality.infeasible_by`) and
cut.py (`duality.Cut`); tests/planning/kernels/test_kernel_proof.py and tests/planning/tick/test_compiled_planning.py
compare them. The numpy code stays the reference, and an answer of a kernel counts only with a proof.
"""
