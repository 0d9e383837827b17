"""A run in three dimensions: what MuJoCo draws of it. Nothing here is simulated; bodies are put where the run was."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np
from matplotlib.colors import to_rgba

from ..frames import Array, rotation_planar
from ..simulation.mujoco_cart import DEFAULT_COM_HEIGHT, WHEEL_RADIUS
from ..wheels import CASTER, DEFAULT_TRAIL
from .plots import GREEN, OKABE_ITO, PURPLE, REFERENCE_COLOUR
from .shown_run import ShownRun
from .top_view import BODY_COLOUR, EDGE_COLOUR, MAX_ARROW_FRACTION, WHEEL_COLOUR, large_force

DECK_HEIGHT = 2 * WHEEL_RADIUS + 0.04
"""m: where the deck lies."""
DEFAULT_BODY_HEIGHT = 0.9
"""m, of the body where no arm tells where it holds."""
ROD_RADIUS, PATH_LINE_RADIUS, HAND_RADIUS, MIN_DRAWN_COM_STD = 0.012, 0.006, 0.03, 0.012
"""m: half-widths of the frame, of paths and hands, and of the CoM's ellipsoid at least."""
WRIST_LENGTH = 0.22
"""m of each arm are drawn."""
PATH_SEGMENTS = 400
ELEVATION, AZIMUTH = -24.0, 125.0
"""Degrees, of the camera."""
SCENE_WIDTH, SCENE_HEIGHT = 800, 600
IDENTITY_ROTATION = np.eye(3)


@dataclass(frozen=True, eq=False)
class Scene:
    """The model, and where its moving bodies (cart, then wheels) are in {b}: `wheels` (k, 2) with trails (k,) behind
    pivots that turn where `is_caster`."""

    run: ShownRun
    model: mujoco.MjModel
    height: float
    wheels: Array
    trails: Array
    is_caster: np.ndarray

    @classmethod
    def of(cls, run: ShownRun) -> Scene:
        height = _height(run)
        wheels = () if run.cart is None else run.cart.wheels
        is_caster = np.array([wheel.kind == CASTER for wheel in wheels], dtype=bool)
        return cls(
            run=run,
            model=_spec(run, height).compile(),
            height=height,
            wheels=np.array([(wheel.x, wheel.y) for wheel in wheels]).reshape(-1, 2),
            trails=np.array([(wheel.trail or DEFAULT_TRAIL) if wheel.kind == CASTER else 0.0 for wheel in wheels]),
            is_caster=is_caster,
        )

    def placed(self, i: int) -> mujoco.MjData:
        """Bodies as at instant i, whose pose is known."""
        data = mujoco.MjData(self.model)
        x, y, theta = self.run.pose[i].tolist()
        headings = np.zeros(len(self.wheels))
        if self.run.caster_headings is not None:
            headings[self.is_caster] = np.nan_to_num(self.run.caster_headings[i])
        turned = np.append(theta, theta + headings)
        behind = self.trails[:, None] * np.column_stack([np.cos(headings), np.sin(headings)])
        centres = (self.wheels - behind) @ rotation_planar(theta).T + (x, y)
        data.mocap_pos[0, :2], data.mocap_pos[1:, :2], data.mocap_pos[1:, 2] = (x, y), centres, WHEEL_RADIUS
        data.mocap_quat[:] = np.column_stack([np.cos(turned / 2), 0 * turned, 0 * turned, np.sin(turned / 2)])
        mujoco.mj_forward(self.model, data)
        return data

    def camera(self, i: int) -> mujoco.MjvCamera:
        """Looks at the cart, and stays with it."""
        camera, (x0, x1, y0, y1) = mujoco.MjvCamera(), self.run.outline
        camera.lookat[:] = *self.run.pose[i, :2], 0.45 * self.height
        camera.distance = 2.6 * max(x1 - x0, y1 - y0, self.height)
        camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
        return camera

    def draw_over(self, scene: mujoco.MjvScene, i: int) -> None:
        """Adds what no body is: paths on the floor, arms and their forces, the estimated CoM."""
        for path, colour in ((self.run.reference_pose, REFERENCE_COLOUR), (self.run.pose, GREEN)):
            for start, stop in _stretches(path):
                _join(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, PATH_LINE_RADIUS, (start, stop), to_rgba(colour))
        self._draw_arms(scene, i)
        self._draw_com(scene, i)

    def _draw_arms(self, scene: mujoco.MjvScene, i: int) -> None:
        x0, x1, y0, y1 = self.run.outline
        centre, scale = np.array([(x0 + x1) / 2, (y0 + y1) / 2]), MAX_ARROW_FRACTION * (x1 - x0) / large_force(self.run)
        for k, (name, contacts) in enumerate(self.run.contacts.items()):
            contact, colour = contacts[i], to_rgba(OKABE_ITO[k % len(OKABE_ITO)])
            if not np.isfinite(contact).all():
                continue
            out = contact[:2] - centre
            out = np.append(out / max(float(np.hypot(*out)), 1e-9), 0.4)
            hand, wrist = self._in_s(contact, i), self._in_s(contact + WRIST_LENGTH * out, i)
            rim = np.append(np.clip(contact[:2], [x0, y0], [x1, y1]), min(contact[2], self.height))
            _join(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, ROD_RADIUS, (self._in_s(rim, i), hand), to_rgba(EDGE_COLOUR))
            _add(scene, mujoco.mjtGeom.mjGEOM_SPHERE, (HAND_RADIUS, HAND_RADIUS, HAND_RADIUS), hand, colour)
            _join(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, 0.7 * HAND_RADIUS, (hand, wrist), to_rgba(REFERENCE_COLOUR))
            force = scale * self.run.wrenches[name][i, :3]
            if np.isfinite(force).all() and np.linalg.norm(force) > HAND_RADIUS:
                tip = self._in_s(contact + force, i)
                _join(scene, mujoco.mjtGeom.mjGEOM_ARROW, 0.6 * HAND_RADIUS, (hand, tip), colour)

    def _draw_com(self, scene: mujoco.MjvScene, i: int) -> None:
        """One standard deviation, along {b}'s axes."""
        known, cart = self.run.estimated_com(i), self.run.cart
        if known is None:
            return
        com, covariance = known
        height = None if cart is None else cart.com_height
        size = np.maximum([*(np.sqrt(np.diagonal(covariance))), 0.0], MIN_DRAWN_COM_STD)
        turned = np.eye(3)
        turned[:2, :2] = rotation_planar(self.run.pose[i, 2])
        place = self._in_s(np.array([*com, DEFAULT_COM_HEIGHT if height is None else height]), i)
        _add(scene, mujoco.mjtGeom.mjGEOM_ELLIPSOID, tuple(size.tolist()), place, to_rgba(PURPLE), turned)

    def _in_s(self, point_b: Array, i: int) -> Array:
        x, y, theta = self.run.pose[i].tolist()
        return np.append(rotation_planar(theta) @ point_b[:2] + (x, y), point_b[2])


def _height(run: ShownRun) -> float:
    """The height of the body, m: up to the highest hand."""
    held = [contact[np.isfinite(contact[:, 2]), 2] for contact in run.contacts.values()]
    highest = max((float(np.median(z)) for z in held if len(z)), default=0.0)
    return float(np.clip(highest, DECK_HEIGHT + 0.2, 2.0)) if highest > 0 else DEFAULT_BODY_HEIGHT


def _spec(run: ShownRun, height: float) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = SCENE_WIDTH, SCENE_HEIGHT
    spec.visual.quality.shadowsize = 4096
    spec.visual.headlight.ambient[:], spec.visual.headlight.diffuse[:] = 0.45, 0.3
    spec.visual.map.znear = 0.02
    sky = {"type": mujoco.mjtTexture.mjTEXTURE_SKYBOX, "builtin": mujoco.mjtBuiltin.mjBUILTIN_GRADIENT}
    spec.add_texture(name="sky", **sky, rgb1=[1.0, 1.0, 1.0], rgb2=[0.86, 0.9, 0.94], width=64, height=384)
    tiles = {"type": mujoco.mjtTexture.mjTEXTURE_2D, "builtin": mujoco.mjtBuiltin.mjBUILTIN_CHECKER}
    spec.add_texture(name="tiles", **tiles, rgb1=[0.93, 0.94, 0.95], rgb2=[0.88, 0.9, 0.92], width=256, height=256)
    floor = spec.add_material(name="floor", texrepeat=[1.0, 1.0], texuniform=True)
    floor.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    world = spec.worldbody
    lamp = {"pos": [0.5, -0.8, 4.0], "dir": [-0.1, 0.2, -1.0], "diffuse": [0.4] * 3, "specular": [0.1] * 3}
    world.add_light(**lamp, mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACKCOM)
    world.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 0.1], material="floor")
    _add_body(world.add_body(name="cart", mocap=True), run, height)
    for wheel in () if run.cart is None else run.cart.wheels:
        body = world.add_body(mocap=True)
        across = [math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0]
        size = [WHEEL_RADIUS, 0.35 * WHEEL_RADIUS, 0.0]
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=size, quat=across, rgba=to_rgba(WHEEL_COLOUR))
        if wheel.kind == CASTER:
            trail = wheel.trail or DEFAULT_TRAIL
            _rod(body, (0.0, 0.0, 0.0), (trail, 0.0, DECK_HEIGHT - WHEEL_RADIUS), EDGE_COLOUR)
    return spec


def _add_body(cart: mujoco.MjsBody, run: ShownRun, height: float) -> None:
    """A deck, and a basket that one can see through."""
    x0, x1, y0, y1 = run.outline
    centre, half = ((x0 + x1) / 2, (y0 + y1) / 2), ((x1 - x0) / 2, (y1 - y0) / 2)
    deck = {"pos": [*centre, DECK_HEIGHT], "size": [*half, 0.02], "rgba": to_rgba(BODY_COLOUR)}
    cart.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, **deck)
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    for (x, y), (other_x, other_y) in zip(corners, corners[1:] + corners[:1], strict=True):
        _rod(cart, (x, y, DECK_HEIGHT), (x, y, height), EDGE_COLOUR)
        _rod(cart, (x, y, height), (other_x, other_y, height), EDGE_COLOUR)
        middle = [(x + other_x) / 2, (y + other_y) / 2, (DECK_HEIGHT + height) / 2]
        size = [max(abs(x - other_x) / 2, 0.002), max(abs(y - other_y) / 2, 0.002), (height - DECK_HEIGHT) / 2]
        wall = {"pos": middle, "size": size, "rgba": to_rgba(EDGE_COLOUR, 0.12)}
        cart.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, **wall)


def _rod(body: mujoco.MjsBody, start: tuple[float, ...], stop: tuple[float, ...], colour: str) -> None:
    ends = {"fromto": [*start, *stop], "size": [ROD_RADIUS, 0.0, 0.0], "rgba": to_rgba(colour)}
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, **ends)


def _stretches(pose: Array | None) -> Iterator[tuple[Array, Array]]:
    """The stretches of a path on the floor, as their two ends (3,); none where a pose is missing."""
    if pose is None:
        return
    rows = np.unique(np.linspace(0, len(pose) - 1, PATH_SEGMENTS + 1).astype(int))
    points = np.column_stack([pose[rows, :2], np.full(len(rows), PATH_LINE_RADIUS)])
    for start, stop in pairwise(points):
        if np.isfinite([start, stop]).all() and not np.array_equal(start, stop):
            yield start, stop


def _add(
    scene: mujoco.MjvScene,
    kind: mujoco.mjtGeom,
    size: tuple[float, ...],
    place: Array,
    colour: tuple[float, ...],
    turned: Array = IDENTITY_ROTATION,
) -> None:
    if scene.ngeom < scene.maxgeom:
        geom = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(geom, kind, np.array(size), place, turned.ravel(), np.array(colour, dtype=np.float32))
        scene.ngeom += 1


def _join(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, width: float, ends: tuple[Array, Array], colour: tuple[float, ...]
) -> None:
    before = scene.ngeom
    _add(scene, kind, (0.0, 0.0, 0.0), np.zeros(3), colour)
    if scene.ngeom > before:
        mujoco.mjv_connector(scene.geoms[before], kind, width, *ends)
