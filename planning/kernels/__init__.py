"""What runs at controller rate, compiled by numba. Nothing here is imported before a planner's `warm_up`.

Each kernel states in its head which numpy code it mirrors; `tests/planning/test_kernels.py` and its neighbours
compare the two. The numpy code stays the reference: a kernel's answer counts only with a proof of that form.
"""
