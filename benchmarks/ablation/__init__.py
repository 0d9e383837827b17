"""Which constants of the discrepancy engine decide, and what each buys: `python -m benchmarks.ablation`.

Every constant of `estimation/weak_form` and `estimation/discrepancy` is listed (`deciding.py`, `assumptions.py`,
`numerics.py`); those that decide or assume are switched off and moved, one at a time, and all logs diagnosed anew.
"""
