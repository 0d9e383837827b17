"""Every range that something is drawn from. A pair is uniform; `signed` draws get either sign.

Sizes are such that an effect makes 5 to 40 % of the drive force at times; those in proportion to the cart are
written per kg of a cart (`heavy`).
"""

from __future__ import annotations

CART = {
    "mass": (15.0, 60.0),
    "com_x": (0.2, 0.45),
    "com_y": (-0.06, 0.06),
    "gyration": (0.24, 0.38),  # m, radius
    "com_height": (0.3, 0.7),
    "half_track": (0.2, 0.3),
    "caster_x": (0.6, 0.9),
    "caster_y": (0.15, 0.25),
    "trail": (0.03, 0.06),
    "linear": (0.1, 0.3),  # N s/m per kg
    "angular": (0.05, 0.12),  # N m s/rad per kg
}
NOMINAL = {"mass": 0.25, "inertia": 0.25, "drag": 0.25, "com": 0.05}
"""How wrong the believed cart may be: shares, and m."""
CONTACT = {"x": (-0.5, -0.15), "y": (-0.3, 0.3), "z": (0.8, 1.1), "step": 0.12}

NOISE = {"force": 3.0, "moment": (0.1, 0.3), "pose": 5e-4, "speed": 5e-3, "jitter": 3e-4}
COLOUR = (0.02, 0.08)  # s, correlation time of coloured force noise

EFFECTS: dict[str, dict[str, tuple[float, float]]] = {
    "viscous_drag": {"linear": (0.25, 0.5), "angular": (0.08, 0.16)},
    "rolling_resistance": {"coefficient": (0.012, 0.03)},
    "stribeck_friction": {"breakaway": (0.15, 0.4), "speed": (0.03, 0.08)},
    "quadratic_drag": {"coefficient": (0.4, 0.9)},
    "directional_drag": {"forward": (0.0, 0.08), "backward": (0.3, 0.6)},
    "floor_slope": {"grade": (0.01, 0.03), "bow": (0.0, 0.1)},
    "floor_patch": {"coefficient": (0.025, 0.05), "size": (1.0, 2.0), "ramp": (0.01, 0.04)},
    "caster_realignment": {"swivel": (0.003, 0.008), "scrub": (0.1, 0.3)},
    "wheel_drag_imbalance": {"brake": (0.12, 0.3)},
    "wheel_misalignment": {"angle": (0.015, 0.05)},
    "lateral_slip": {"cornering": (8.0, 25.0), "relaxation": (0.03, 0.08)},
    "payload_change": {"mass": (0.15, 0.35), "x": (0.0, 0.6), "y": (-0.2, 0.2), "ramp": (0.02, 0.5)},
    "load_slosh": {"mass": (0.2, 0.4), "frequency": (0.6, 1.4), "damping": (0.02, 0.1)},
    "force_bias": {"fx": (2.0, 6.0), "fy": (2.0, 6.0), "tz": (0.3, 1.0)},
    "force_scale": {"gain": (0.12, 0.25)},
    "force_misalignment": {"angle": (0.1, 0.25)},
    "time_delay": {"delay": (0.013, 0.047)},
    "external_push": {"force": (0.6, 1.4), "duration": (0.5, 1.5), "lever": (-0.25, 0.25)},
    "contact_offset": {"x": (0.0, 0.03), "y": (0.04, 0.08)},
    "tool_inertia": {"mass": (1.5, 3.0), "x": (0.0, 0.08), "y": (0.0, 0.05), "z": (0.0, 0.08)},
    "pose_offset": {"x": (0.03, 0.1), "y": (0.0, 0.05), "yaw": (0.0, 0.03)},
    "flat_spot": {"force": (0.2, 0.5), "period": (0.25, 0.6)},
    "wind": {"force": (0.3, 0.7)},
    "oscillating_floor": {"acceleration": (0.15, 0.4), "frequency": (0.3, 1.2)},
}
BRISTLE = (8e-4, 2e-3)  # m
TANH_WIDTH = (0.004, 0.012)  # m/s

ROUGH: dict[str, dict[str, tuple[float, float]]] = {
    "bursts": {"rhythm": (0.6, 1.2), "pushed": (0.35, 0.6), "uneven": (0.15, 0.35), "jitter": (0.05, 0.15)},
    "leaning_load": {"rider": (0.35, 0.6), "frequency": (0.8, 1.5), "damping": (0.5, 0.9), "at_once": (0.4, 0.8)},
    "force_lag": {"lag": (0.02, 0.08)},
    "late_velocities": {"delay": (0.01, 0.05)},
    "large_velocities": {"gain": (1.03, 1.05)},
    "sensor_track": {"scale": (0.3, 1.0)},
    "rail": {"stroke": (1.0, 3.0), "speed": (0.25, 0.9), "acceleration": (0.35, 0.9), "rest": (0.0, 1.2)},
    "coasting": {"speed": (0.8, 2.0), "yaw_rate": (-0.4, 0.4), "duration": (10.0, 25.0)},
}
"""Hz, and shares of a stroke, of its strength and of its length; shares of the mass and of the push that accelerates
the rider at once, Hz, share of critical; s; s; -; of the track as it is; m, m/s, m/s², s; m/s, rad/s, s."""
POSE_STEPS = (5e-4, 2e-3, 1e-2)  # m
BY_HAND = 1.5, 0.5
"""1/s and 1/s²: how a person holds a speed, and its integral, who pushes in bursts or leans."""
GUESS = {"factor": (1 / 3, 3.0), "com": 0.15}
"""Of the true mass and inertia; m."""
