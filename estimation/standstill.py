"""Below which speed a cart may stand: brakes, chocks and dry friction then hold any force, and nothing is taught."""

STANDSTILL_SPEED = 0.02
"""m/s, of {b}'s origin and, by `HALF_TRACK`, of its turning."""
HALF_TRACK = 0.35
"""m: half of a usual track."""
