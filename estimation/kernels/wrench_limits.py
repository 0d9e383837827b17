"""What a recorded wrench may be, and for how long it counts; kernels and Python alike."""

HELD = 0.1
"""s: for how long a wrench is taken to go on."""
MOST_FORCE = 1e6
"""N, N·m: more in all is no wrench, nor is NaN."""
JUMP = 14.0
"""Normalised square of a step of the wrench that is no noise."""
MOST_JOLT = 100.0
"""m/s² or rad/s²: what such a step may change."""
