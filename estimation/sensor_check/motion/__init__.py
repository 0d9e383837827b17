"""Poses and velocities: headings, frames, units, clocks and scales."""
