"""The steering law of tracking.py as scalar code: Python calls it, and kernels compile it."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

MIN_REFERENCE_SPEED = 1e-3
"""Magnitude of a component of nu (m/s, rad/s) below which a reference counts as at rest."""

Pair = tuple[float, float]
Triple = tuple[float, float, float]
GainNumbers = tuple[float, float, float, float, float]


def error_b(reference_sb: Array, pose_sb: Array, axle: float) -> Triple:
    """Position error of the axle's middle in {b}, and heading error in [-pi, pi)."""
    wrapped = (reference_sb[2] - pose_sb[2] + math.pi) % (2.0 * math.pi) - math.pi
    cosine, sine = math.cos(pose_sb[2]), math.sin(pose_sb[2])
    x = reference_sb[0] + axle * math.cos(reference_sb[2]) - (pose_sb[0] + axle * cosine)
    y = reference_sb[1] + axle * math.sin(reference_sb[2]) - (pose_sb[1] + axle * sine)
    return cosine * x + sine * y, cosine * y - sine * x, wrapped if wrapped < math.pi else -math.pi


def steered(error: Triple, angle: float, velocity: Pair, wanted: tuple[Pair, Pair], gains: GainNumbers) -> Pair:
    """nu' of Kanayama's law: `error` as above, of wheels that roll at `angle`; nu; nu and nu' of the reference; gains
    along, across, of heading and of velocity, and the reach of errors."""
    (u, r), (u_d, r_d), (du_d, dr_d) = velocity, wanted[0], wanted[1]
    along, across, turning, quickly, reach = gains
    cosine, sine = math.cos(angle), math.sin(angle)
    e_x, e_y, e_h = cosine * error[0] + sine * error[1], cosine * error[1] - sine * error[0], error[2]
    cosine, sine = math.cos(e_h), math.sin(e_h)
    e_x_rate = r * e_y - u + u_d * cosine
    e_y_rate = -r * e_x + u_d * sine
    e_h_rate = r_d - r
    longer, longer_h = math.sqrt(1.0 + (e_x**2 + e_y**2) / reach**2), math.sqrt(1.0 + e_h**2 / reach**2)
    s_x, s_y, s_h = e_x / longer, e_y / longer, e_h / longer_h
    longer_rate = (s_x * e_x_rate + s_y * e_y_rate) / reach**2
    s_x_rate, s_y_rate = (e_x_rate - s_x * longer_rate) / longer, (e_y_rate - s_y * longer_rate) / longer
    s_h_rate = e_h_rate / longer_h**3
    if abs(e_h) < 1e-4:
        sinc, sinc_slope = 1.0 - e_h**2 / 6.0, -e_h / 3.0
    else:
        sinc, sinc_slope = sine / e_h, (e_h * cosine - sine) / e_h**2
    u_c = u_d * cosine + along * s_x
    u_c_rate = du_d * cosine - u_d * sine * e_h_rate + along * s_x_rate
    r_c = r_d + across * u_d * s_y * sinc + turning * s_h
    r_c_rate = dr_d + turning * s_h_rate
    r_c_rate += across * (du_d * s_y * sinc + u_d * s_y_rate * sinc + u_d * s_y * sinc_slope * e_h_rate)
    return u_c_rate + quickly * (u_c - u), r_c_rate + quickly * (r_c - r)
