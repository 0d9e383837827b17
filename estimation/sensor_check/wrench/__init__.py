"""Force sensors: signs, axes, frames, units, and waves of sensors that turn with a wheel."""
