"""The closed loop as compiled code: the kernels of plant, filter and planner, with no Python between them."""
