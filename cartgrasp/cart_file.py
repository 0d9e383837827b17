"""`cart.yaml` <-> `CartModel`: strict to read, exact about places, faithful to the reader's comments and order."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field
from ruamel.yaml.comments import CommentedMap, CommentedSeq

from .checks import MAX_DISTANCE, MAX_NUMBER, did_you_mean, listed
from .constraints import RollingConstraints
from .effects import KNOWN_EFFECTS, ConstraintEffect, Effect, LoadSlosh, PayloadChange
from .effects.effect import Setting
from .errors import CartgraspError, FileError, SettingError, UsageError
from .first_guess import PHYSICAL_NAMES, FirstGuess
from .inertia import Inertia, phi_from_physical
from .model import CartModel
from .wheels import Wheel
from .writing import write_atomically
from .yaml_file import StrictModel, dump_yaml, file_error, parse_yaml, plain, read_yaml, validate

Location = Sequence[str | int]


class _WheelEntry(StrictModel):
    kind: str
    x: float
    y: float
    trail: float = 0.0


class _CartEntry(StrictModel):
    name: str = "cart"
    mass: float
    com: list[float] = Field(min_length=2, max_length=2)
    inertia: float
    com_height: float | None = None
    constraints: list[dict[str, Any]] = Field(default_factory=list)
    wheels: list[_WheelEntry] = Field(default_factory=list)
    effects: dict[str, Any] = Field(default_factory=dict)
    std: dict[str, Any] = Field(default_factory=dict)
    known: list[str] = Field(default_factory=list)


def load_cart(path: str | os.PathLike[str], effects: Sequence[type[Effect]] = ()) -> CartModel:
    """The cart of a `cart.yaml`.

    Args:
        path: Of the file: keys as in the command line's pages, SI units.
        effects: Classes of effects of your own that it may have beside the library's.

    Raises:
        FileError: It can't be read, or holds a mistake: `file:line:column: key: why`.

    Example:
        >>> import cartgrasp as cg
        >>> cart = cg.load_cart("cart.yaml")
        >>> cart.inertia.mass, [effect.key for effect in cart.effects]
        (15.0, ['viscous_drag'])
    """
    form = "write effects=[CubicDrag], the classes of your own"
    own: tuple[type[Effect], ...] = listed("load_cart: effects", effects, type, form)
    for kind in own:
        if not issubclass(kind, Effect):
            raise UsageError(f"load_cart: effects: {kind.__name__} is no Effect; {form}")
    return cart_from_document(read_yaml(path), str(path), own=own)


def cart_from_text(text: str, name: str = "cart.yaml") -> CartModel:
    return cart_from_document(parse_yaml(text, name), name)


def cart_from_document(
    document: CommentedMap, name: str, prefix: Location = (), own: Sequence[type[Effect]] = ()
) -> CartModel:
    """The cart of a mapping that stands under the keys `prefix` of a file called `name`, with effects of the library
    and of one's `own`."""
    entry = validate(_CartEntry, document, name, prefix)

    def refuse(location: Location, why: str) -> FileError:
        return file_error(document, name, location, why, prefix)

    if entry.mass <= 0:
        raise refuse(["mass"], f"{entry.mass:g} kg is not positive")
    if entry.inertia <= 0:
        why = f"{entry.inertia:g} kg m² about the CoM is not positive, so J m > |m d|² fails"
        raise refuse(["inertia"], why)
    if max(map(abs, entry.com)) > MAX_DISTANCE:
        raise refuse(["com"], f"{entry.com} is beyond {MAX_DISTANCE:g} m; lengths are in m")
    x, y = entry.mass * entry.com[0], entry.mass * entry.com[1]
    product = entry.mass * entry.inertia + (x * x + y * y)
    if not x * x + y * y < product < math.inf:
        why = f"so far off that beside it {entry.inertia:g} kg m² is rounded away, and J m > |m d|² fails"
        raise refuse(["com"], why)
    if entry.com_height is not None and entry.com_height < 0:
        raise refuse(["com_height"], f"{entry.com_height:g} m is below the floor")
    if entry.com_height is not None and entry.com_height > MAX_DISTANCE:
        raise refuse(["com_height"], f"{entry.com_height:g} m is beyond {MAX_DISTANCE:g} m; lengths are in m")
    known = KNOWN_EFFECTS | {kind.name: kind for kind in own}
    constraints, effects = _constraints(entry.constraints, refuse), _effects(entry.effects, known, refuse)
    for effect in effects:
        if isinstance(effect, ConstraintEffect):
            try:
                effect.check(constraints)
            except CartgraspError as error:
                raise refuse(["effects", effect.name], str(error)) from error
    swung = sum(effect.mass for effect in effects if isinstance(effect, LoadSlosh))
    if swung >= entry.mass:
        why = f"{swung:g} kg swings on a cart of {entry.mass:g} kg; give `mass` of the cart with all that swings on it"
        raise refuse(["effects", "load_slosh"], why)
    body = Inertia(entry.mass, (entry.com[0], entry.com[1]), entry.inertia)
    _check_payloads(body, [effect for effect in effects if isinstance(effect, PayloadChange)], refuse)
    return CartModel(
        inertia=body,
        constraints=constraints,
        effects=effects,
        wheels=_wheels(entry.wheels, refuse),
        com_height=entry.com_height,
        name=entry.name,
        first_guess=_first_guess(entry, effects, refuse),
        source=dump_yaml(document),
    )


def save_cart(cart: CartModel, path: str | os.PathLike[str]) -> Path:
    """Writes the cart; comments and order of the file that it was read from stay."""
    return write_atomically(path, cart_text(cart))


def cart_text(cart: CartModel) -> str:
    document = parse_yaml(cart.source, "cart.yaml") if cart.source else CommentedMap()
    entries = _entries(cart)
    for stale in ("com_height", "wheels", "std", "known"):
        if stale in document and stale not in entries:
            del document[stale]
    for key, value in entries.items():
        _put(document, key, value)
    _order(document.get("effects"), entries["effects"])
    return dump_yaml(document)


def _constraints(entries: list[dict[str, Any]], refuse: Any) -> RollingConstraints:
    axle_x, no_rotation = None, False
    for i, entry in enumerate(entries):
        where: list[str | int] = ["constraints", i]
        if len(entry) != 1 or next(iter(entry)) not in ("no_lateral_slip", "no_rotation"):
            found = ", ".join(entry) or "nothing"
            raise refuse(where, f"{found}: each entry is `no_lateral_slip: {{x: …}}` or `no_rotation: {{}}`")
        kind, values = next(iter(entry.items()))
        where.append(kind)
        allowed = {"x"} if kind == "no_lateral_slip" else set()
        if not isinstance(values, dict) or not set(values) <= allowed:
            raise refuse(where, f"{values!r} is not {'{x: …}' if allowed else 'an empty mapping {}'}")
        if kind == "no_rotation":
            if no_rotation:
                raise refuse(where, "stands twice; keep one")
            no_rotation = True
            continue
        if axle_x is not None:
            raise refuse(where, "stands twice; two axles at different x are a rail: use `no_rotation: {}`")
        axle_x = _number(values.get("x", 0.0), [*where, "x"], refuse)
        if abs(axle_x) > MAX_DISTANCE:
            raise refuse([*where, "x"], f"{axle_x:g} m is beyond {MAX_DISTANCE:g} m; lengths are in m")
    if no_rotation and axle_x is None:
        raise refuse(["constraints"], "no_rotation needs no_lateral_slip beside it (a rail has both)")
    return RollingConstraints(axle_x, no_rotation)


def _wheels(entries: list[_WheelEntry], refuse: Any) -> tuple[Wheel, ...]:
    wheels = []
    for i, entry in enumerate(entries):
        if entry.kind not in ("fixed", "caster"):
            raise refuse(["wheels", i, "kind"], f"{entry.kind!r} is neither fixed nor caster")
        if entry.trail < 0:
            raise refuse(["wheels", i, "trail"], f"{entry.trail:g} m is negative")
        try:
            wheels.append(Wheel(entry.kind, entry.x, entry.y, entry.trail))
        except CartgraspError as error:
            raise refuse(["wheels", i], str(error)) from error
    return tuple(wheels)


def _effects(entries: Mapping[str, Any], known: Mapping[str, type[Effect]], refuse: Any) -> tuple[Effect, ...]:
    effects: list[Effect] = []
    for name, values in entries.items():
        kind = known.get(name)
        if kind is None:
            cure = "an effect of your own is given in Python: load_cart(path, effects=[…])"
            raise refuse(["effects", name], f"unknown effect{did_you_mean(name, known)} ({cure})")
        values = {} if values is None else values
        if not isinstance(values, dict):
            raise refuse(["effects", name], f"{values!r} is not a mapping of parameters")
        own = {key: value for key, value in values.items() if not isinstance(value, dict)}
        for label in _labels(values) or [None]:
            where = ["effects", name] if label is None else ["effects", name, label]
            numbers = own if label is None else values[label]
            effect = _effect(kind, "" if label is None else str(label), numbers, where, refuse)
            if effect.key in (other.key for other in effects):
                raise refuse(where, f"{effect.key} stands twice; give each its own label")
            effects.append(effect)
    return tuple(effects)


def _check_payloads(body: Inertia, loads: Sequence[PayloadChange], refuse: Any) -> None:
    """Refuses a cart that is no body once its loads have been put on and taken off, one after the other."""
    phi = body.phi
    for load in sorted(loads, key=lambda load: (load.time, -load.mass)):
        with np.errstate(all="ignore"):  # what is too large is no body either
            phi = phi + phi_from_physical(load.mass, load.x, load.y, 0.0)
        try:
            Inertia.from_phi(phi)
        except CartgraspError as error:
            why = f"{load.mass:g} kg from {load.time:g} s on leaves no cart: {error}; take off what is on it"
            raise refuse(["effects", load.name, *filter(None, [load.label])], why) from error


def _first_guess(entry: _CartEntry, effects: Sequence[Effect], refuse: Any) -> FirstGuess:
    names = [*PHYSICAL_NAMES, *(key for effect in effects for key in effect.keys)]
    std = {}
    for name, value in entry.std.items():
        if name not in names:
            raise refuse(["std", name], f"is no parameter of this cart{did_you_mean(str(name), names)}")
        std[name] = _number(value, ["std", name], refuse)
        if std[name] <= 0:
            raise refuse(["std", name], f"{std[name]:g} is not positive; what is sure stands under `known`")
        if std[name] > MAX_NUMBER:
            raise refuse(["std", name], f"{std[name]:g} is beyond {MAX_NUMBER:g}; leave it out where nothing is known")
    allowed = [*names, *(effect.key for effect in effects)]
    for i, name in enumerate(entry.known):
        if name not in allowed:
            raise refuse(["known", i], f"{name!r} is no parameter of this cart{did_you_mean(name, allowed)}")
        if name in std:
            raise refuse(["known", i], f"{name} stands under `std` too; keep one")
    return FirstGuess(tuple(std.items()), tuple(dict.fromkeys(entry.known)))


def _labels(values: Mapping[Any, Any]) -> list[Any]:
    """The labels of an effect's entries in their order; None stands for its own, unlabelled numbers."""
    return list(dict.fromkeys(key if isinstance(value, dict) else None for key, value in values.items()))


def _effect(kind: type[Effect], label: str, numbers: Mapping[str, Any], where: Location, refuse: Any) -> Effect:
    try:
        effect = kind(label=label, **_settings(kind.settings, numbers, where, refuse))
    except SettingError as error:
        raise refuse([*where, error.name], error.why) from error
    known = {p.name: i for i, p in enumerate(effect.parameters)}
    settings, values = [setting.name for setting in kind.settings], effect.values.copy()
    for key, value in numbers.items():
        if key in settings:
            continue
        if key not in known:
            raise refuse([*where, key], f"unknown parameter{did_you_mean(str(key), [*settings, *known])}")
        number, parameter = _number(value, [*where, key], refuse), effect.parameters[known[key]]
        if not parameter.lower <= number <= parameter.upper:
            low, high = f"{parameter.lower:g}", f"{parameter.upper:g}"
            raise refuse([*where, key], f"{number:g} {parameter.unit} is outside [{low}, {high}]")
        values[known[key]] = number
    try:
        return effect.with_values(values)
    except CartgraspError as error:
        raise refuse(where, str(error)) from error


def _settings(settings: Sequence[Setting], entries: Mapping[str, Any], where: Location, refuse: Any) -> dict[str, Any]:
    """Those that stand in an effect's entries; which words it has must stand there."""
    found: dict[str, Any] = {}
    for setting in settings:
        place = [*where, setting.name]
        if setting.name not in entries:
            if setting.words:
                raise refuse(place, f"is missing; add one of {', '.join(setting.words)}")
            continue
        value = entries[setting.name]
        if setting.is_list:
            if not isinstance(value, list):
                raise refuse(place, f"{value!r} is not a list of numbers")
            value = tuple(_number(number, [*place, i], refuse) for i, number in enumerate(value))
        elif not setting.words:
            value = _number(value, place, refuse)
        found[setting.name] = value
    return found


def _number(value: Any, where: Location, refuse: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise refuse(where, f"{value!r} is not a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise refuse(where, f"{value} is not a finite number")
    return number


def _entries(cart: CartModel) -> dict[str, Any]:
    entries: dict[str, Any] = {
        "name": cart.name,
        "mass": float(cart.inertia.mass),
        "com": [float(v) for v in cart.inertia.com],
        "inertia": float(cart.inertia.about_com),
    }
    if cart.com_height is not None:
        entries["com_height"] = float(cart.com_height)
    constraints: list[dict[str, Any]] = []
    if cart.constraints.axle_x is not None:
        constraints.append({"no_lateral_slip": {"x": float(cart.constraints.axle_x)}})
    if cart.constraints.no_rotation:
        constraints.append({"no_rotation": {}})
    entries["constraints"] = constraints
    if cart.wheels:
        entries["wheels"] = [_wheel_entry(wheel) for wheel in cart.wheels]
    effects: dict[str, Any] = {}
    for effect in cart.effects:
        numbers = {p.name: float(v) for p, v in zip(effect.parameters, effect.values, strict=True)}
        entry = _setting_entries(effect) | numbers
        own = effects.setdefault(effect.name, {})
        own.update({effect.label: entry} if effect.label else entry)
    entries["effects"] = effects
    if cart.first_guess.std:
        entries["std"] = dict(cart.first_guess.std)
    if cart.first_guess.known:
        entries["known"] = list(cart.first_guess.known)
    return entries


def _setting_entries(effect: Effect) -> dict[str, Any]:
    """Words, and what is not as it would be unless given."""
    usual = {item.name: item.default for item in fields(effect)}
    values = {setting: getattr(effect, setting.name) for setting in effect.settings}
    given = {s: value for s, value in values.items() if s.words or value != usual[s.name]}
    return {s.name: list(value) if s.is_list else value for s, value in given.items()}


def _wheel_entry(wheel: Wheel) -> dict[str, Any]:
    trail = {"trail": float(wheel.trail)} if wheel.trail else {}
    return {"kind": wheel.kind, "x": float(wheel.x), "y": float(wheel.y), **trail}


def _order(document: Any, effects: Mapping[str, Any]) -> None:
    """Puts effects, and the labels of each, in the cart's order: sensor effects act one after another."""
    if effects and list(document) != list(effects):
        for name in effects:
            document.move_to_end(name)
    for name, values in effects.items():
        if _labels(document[name]) != _labels(values):
            for key in values:
                document[name].move_to_end(key)


def _put(document: Any, key: Any, value: Any) -> None:
    """Sets a value where it differs, going into what is there so that comments and order stay."""
    present = document[key] if (isinstance(document, list) or key in document) else None
    if present is not None and plain(present) == value:
        return
    if isinstance(present, CommentedMap) and isinstance(value, dict) and value:
        for stale in [k for k in present if k not in value]:
            del present[stale]
        for inner, part in value.items():
            _put(present, inner, part)
    elif isinstance(present, CommentedSeq) and isinstance(value, list) and len(present) == len(value):
        for i, part in enumerate(value):
            _put(present, i, part)
    elif value or key in document or not isinstance(value, dict | list):
        document[key] = _fresh(value)


def _fresh(value: Any) -> Any:
    """A new entry, written in one line when it is small."""
    if isinstance(value, dict):
        entry = CommentedMap((k, _fresh(v)) for k, v in value.items())
        if not any(isinstance(v, dict | list) for v in value.values()):
            entry.fa.set_flow_style()
        return entry
    if isinstance(value, list):
        sequence = CommentedSeq(_fresh(v) for v in value)
        if not any(isinstance(v, dict | list) for v in value):
            sequence.fa.set_flow_style()
        return sequence
    return value
