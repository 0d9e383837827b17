"""cart.yaml: what is read is written back, comments and all; mistakes have a place; nothing else escapes."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.cart_file import cart_from_text, cart_text, load_cart
from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ForceBias, ForceScale, RollingResistance, ViscousDrag
from cartgrasp.errors import FileError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel

from .drawn import CONSTRAINTS, SHOPPING_CART, inertias, numbers

CONTRACT = """\
name: shopping cart
mass: 24.0                # kg, loaded
com: [0.30, 0.00]         # m, in {b}
inertia: 2.0              # kg m², about the CoM, vertical axis
com_height: 0.45          # m, optional: needed for tip-over margins
constraints:              # 0, 1 or 2; none for a cart on casters alone
  - no_lateral_slip: {x: 0.0}          # fixed wheels' axle at this x in {b}
wheels:                   # optional: needed for wheel loads, skid and tip-over margins, casters
  - {kind: fixed,  x: 0.00, y:  0.27}
  - {kind: fixed,  x: 0.00, y: -0.27}
  - {kind: caster, x: 0.72, y:  0.20, trail: 0.045}
  - {kind: caster, x: 0.72, y: -0.20, trail: 0.045}
effects:                  # names and parameters as in effects.md; this list is what adds it to the model
  viscous_drag: {linear: 3.0, angular: 1.2}
"""
SHORT = "mass: 20\ncom: [0.3, 0]\ninertia: 2\n"
BARE = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), RollingConstraints(None))


def squeezed(text):
    """Runs of blanks, inside flow mappings and before comments, as ruamel sets them."""
    return re.sub(r"(?<=[,:]) {2,}", " ", re.sub(r" +#", "  #", text))


def test_the_contracts_example_is_what_it_says():
    cart = cart_from_text(CONTRACT)
    assert cart == CartModel(
        inertia=Inertia(24.0, (0.30, 0.0), 2.0),
        constraints=RollingConstraints(0.0),
        effects=(ViscousDrag(3.0, 1.2),),
        wheels=SHOPPING_CART,
        com_height=0.45,
        name="shopping cart",
    )


def test_the_contracts_example_is_written_back_as_it_was():
    written = cart_text(cart_from_text(CONTRACT))
    assert squeezed(written) == squeezed(CONTRACT)
    assert cart_text(cart_from_text(written)) == written


def test_comments_and_order_stay_when_numbers_change(tmp_path):
    text = "inertia: 2.0  # guessed\n# weighed on Tuesday\nmass: 24.0  # kg\n\ncom: [0.30, 0.00]  # m\n"
    text += "effects:\n  viscous_drag: {angular: 1.2, linear: 3.0}  # from coasting\n"
    cart = cart_from_text(text)
    changed = cart.with_inertia(Inertia(30.5, (0.30, 0.1), 2.0)).with_effect(RollingResistance(0.02))
    path = changed.save(tmp_path / "cart.yaml")
    written = path.read_text()
    for line in (
        "inertia: 2.0  # guessed",
        "# weighed on Tuesday",
        "mass: 30.5  # kg",
        "com: [0.30, 0.1]  # m",
        "  viscous_drag: {angular: 1.2, linear: 3.0}  # from coasting",
        "  rolling_resistance: {coefficient: 0.02}",
    ):
        assert line in squeezed(written).splitlines()
    assert re.findall(r"^\w+(?=:)", written, re.MULTILINE)[:4] == ["inertia", "mass", "com", "effects"]
    assert load_cart(path) == changed


@pytest.mark.long
@given(
    inertia=inertias(),
    constraints=st.sampled_from(list(CONSTRAINTS.values())),
    wheels=st.sampled_from([(), SHOPPING_CART, (Wheel("fixed", 0.1, -0.2),)]),
    com_height=st.none() | numbers(0, 2),
    effects=st.lists(
        st.sampled_from([ViscousDrag(3.0, 1.2), RollingResistance(0.02), ForceScale(1.1), ForceBias(1.0)]),
        unique=True,
    ),
    labels=st.lists(st.sampled_from(["left", "right", "1"]), unique=True),
    own_first=st.booleans(),
)
@pytest.mark.parametrize("source", ["", CONTRACT, SHORT], ids=["new", "contract", "short"])
def test_any_cart_round_trip(source, inertia, constraints, wheels, com_height, effects, labels, own_first):
    """Also onto a file that said something else before: what the cart does not have must go."""
    effects = tuple(effects)
    if ForceBias(1.0) in effects:
        at = effects.index(ForceBias(1.0)) + own_first
        effects = (*effects[:at], *(ForceBias(2.0, label=label) for label in labels), *effects[at:])
    cart = CartModel(inertia, constraints, effects, wheels, com_height, "a cart: with # signs")
    kept = cart_text(cart_from_text(source)) if source else ""
    again = cart_from_text(cart_text(replace(cart, source=kept)))
    assert again == cart
    np.testing.assert_array_equal(again.parameters, cart.parameters)
    assert again.parameter_names == cart.parameter_names


def test_the_order_of_sensor_effects_is_kept():
    """Scale then bias is not bias then scale."""
    first, second = ForceScale(1.1), ForceBias(1.0)
    cart = cart_from_text(cart_text(replace(BARE, effects=(first, second))))
    swapped = replace(cart, effects=(second, first))
    assert cart_from_text(cart_text(swapped)).effects == (second, first)


def test_numpy_numbers_are_numbers():
    cart = CartModel(
        Inertia(np.float64(20), (np.float64(0.3), 0.0), np.float64(2)),
        RollingConstraints(np.float64(0.1)),
        (ViscousDrag(np.float64(3.0)),),
        (Wheel("fixed", np.float64(0.1), np.float64(0.2)),),
        np.float64(0.4),
    )
    assert cart_from_text(cart_text(cart)) == cart


def test_what_was_put_on_may_be_taken_off():
    """In whatever order it is written."""
    loads = "effects:\n  payload_change:\n    off: {time: 9, mass: -50, x: 0.3}\n    on: {time: 5, mass: 50, x: 0.3}\n"
    assert cart_from_text(SHORT + loads).phi_at(7.0)[0] == pytest.approx(70.0)


MISTAKES = [
    # text, line, column, key, words
    ("", 1, 1, "", "a mapping `key: value` is needed"),
    ("- a\n", 1, 1, "", "a mapping"),
    ("just words\n", 1, 1, "", "a mapping"),
    ("mass: 20\ninertia: 2\n", 1, 1, "com", "is missing; add it"),
    (SHORT + "masss: 3\n", 4, 1, "masss", "unknown key; did you mean mass?"),
    (SHORT + "com-height: 3\n", 4, 1, "com-height", "unknown key; did you mean com_height?"),
    (SHORT + "height]: 3\n", 4, 1, "height]", "unknown key"),
    (SHORT + "mass: 30\n", 4, 1, "mass", "stands twice in this mapping; keep one"),
    ("com: [0, 0]\nmass: heavy\ninertia: 2\n", 2, 1, "mass", "'heavy' is not a number"),
    ("com: [0, 0]\nmass: true\ninertia: 2\n", 2, 1, "mass", "True is not a number"),
    ("com: [0, 0]\nmass: .nan\ninertia: 2\n", 2, 1, "mass", "nan is not a finite number"),
    ("com: [0, 0]\nmass: .inf\ninertia: 2\n", 2, 1, "mass", "inf is not a finite number"),
    ("com: [0, 0]\nmass: 0\ninertia: 2\n", 2, 1, "mass", "0 kg is not positive"),
    ("com: [0, 0]\nmass: -3.5\ninertia: 2\n", 2, 1, "mass", "-3.5 kg is not positive"),
    ("com: [0, 0]\nmass: 20\ninertia: 0\n", 3, 1, "inertia", r"J m > |m d|² fails"),
    ("com: [0, 0, 0]\nmass: 20\ninertia: 1\n", 1, 1, "com", "at most 2 are allowed"),
    ("com: 0\nmass: 20\ninertia: 1\n", 1, 1, "com", "0 is not a list"),
    ("mass: 20\ncom: [0.3, left]\ninertia: 1\n", 2, 12, "com.1", "'left' is not a number"),
    (SHORT + "com_height: -1\n", 4, 1, "com_height", "below the floor"),
    (SHORT + "std: {mass: 1e13}\n", 4, 7, "std.mass", "1e+13 is beyond 1e+12"),
    (
        SHORT + "effects:\n  payload_change: {mass: 1e300, x: 1e300}\n",
        *(5, 3, "effects.payload_change", "leaves no cart: "),
    ),
    (SHORT + "com_height: 450\n", 4, 1, "com_height", "450 m is beyond 50 m; lengths are in m"),
    (
        SHORT + "effects:\n  payload_change: {time: 10, mass: -30}\n",
        *(5, 3, "effects.payload_change", "-30 kg from 10 s on leaves no cart: mass: -10 kg is not positive"),
    ),
    (
        SHORT + "effects:\n  payload_change:\n    on: {mass: 5, x: 0.3}\n    off: {time: 9, mass: -5, x: 3.0}\n",
        *(7, 5, "effects.payload_change.off", "-5 kg from 9 s on leaves no cart: inertia: "),
    ),
    (SHORT + "name: 5\n", 4, 1, "name", "5 is not text"),
    (SHORT + "constraints: {x: 0}\n", 4, 1, "constraints", "is not a list"),
    (SHORT + "constraints:\n  - no_rotation\n", 5, 5, "constraints.0", "mapping `key: value`; write `no_rotation: {}`"),
    (SHORT + "constraints:\n  - no_slip: {}\n", 5, 5, "constraints.0", "no_slip: each entry is"),
    (SHORT + "constraints:\n  - no_rotation: {}\n", 4, 1, "constraints", "needs no_lateral_slip beside it"),
    (
        SHORT + "constraints:\n  - no_lateral_slip: {y: 0}\n",
        *(5, 5, "constraints.0.no_lateral_slip", "is not {x: …}"),
    ),
    (
        SHORT + "constraints:\n  - no_lateral_slip: {x: .inf}\n",
        *(5, 23, "constraints.0.no_lateral_slip.x", "not a finite number"),
    ),
    (
        SHORT + "constraints:\n  - no_lateral_slip: {x: 0}\n  - no_lateral_slip: {x: 1}\n",
        *(6, 5, "constraints.1.no_lateral_slip", "stands twice"),
    ),
    (
        SHORT + "constraints:\n  - no_lateral_slip: {}\n  - no_rotation: {}\n  - no_rotation: {}\n",
        *(7, 5, "constraints.2.no_rotation", "stands twice"),
    ),
    (SHORT + "wheels:\n  - {kind: fixed, x: 0}\n", 5, 5, "wheels.0.y", "is missing"),
    (SHORT + "wheels:\n  - {kind: fixed, x: 0, y: 0, z: 1}\n", 5, 31, "wheels.0.z", "unknown key; known are kind"),
    (SHORT + "wheels:\n  - {kind: steered, x: 0, y: 0}\n", 5, 6, "wheels.0.kind", "neither fixed nor caster"),
    (SHORT + "wheels:\n  - {kind: caster, x: 0, y: 0, trail: -1}\n", 5, 32, "wheels.0.trail", "is negative"),
    (
        SHORT + "constraints: []\neffects:\n  wheel_misalignment: {angle: 0.02}\n",
        *(6, 3, "effects.wheel_misalignment", "the cart has no fixed wheels; add the constraint no_lateral_slip"),
    ),
    (SHORT + "effects:\n  vicous_drag: {}\n", 5, 3, "effects.vicous_drag", "did you mean viscous_drag?"),
    (
        SHORT + "effects:\n  viscous_drag: 3\n",
        5,
        3,
        "effects.viscous_drag",
        "3 is not a mapping of parameters",
    ),
    (
        SHORT + "effects:\n  viscous_drag: {linaer: 3}\n",
        *(5, 18, "effects.viscous_drag.linaer", "did you mean linear?"),
    ),
    (
        SHORT + "effects:\n  viscous_drag: {linear: x}\n",
        5,
        18,
        "effects.viscous_drag.linear",
        "'x' is not a number",
    ),
    (
        SHORT + "effects:\n  viscous_drag: {linear: yes, angular: -1}\n",
        *(5, 18, "effects.viscous_drag.linear", "'yes' is not a number"),
    ),
    (
        SHORT + "effects:\n  viscous_drag: {linear: 1, angular: -1}\n",
        *(5, 29, "effects.viscous_drag.angular", "-1 N·m·s/rad is outside [0, inf]"),
    ),
    (
        SHORT + "effects:\n  viscous_drag: {linear: " + "9" * 400 + "}\n",
        *(5, 18, "effects.viscous_drag.linear", "is not a finite number"),
    ),
    (
        SHORT + "effects:\n  floor_patch: {x_min: 2, x_max: 1}\n",
        *(5, 3, "effects.floor_patch", "floor_patch.x_min: 2 is above x_max = 1"),
    ),
    (
        SHORT + "effects:\n  force_bias:\n    left: {fx: 1}\n    right: {fz: 1}\n",
        *(7, 13, "effects.force_bias.right.fz", "unknown parameter"),
    ),
    (
        SHORT + "effects:\n  force_bias:\n    left: {fx: 1}\n    right: 3\n",
        *(7, 5, "effects.force_bias.right", "unknown parameter; known are fx, fy, tz"),
    ),
    (
        SHORT + "effects:\n  force_bias:\n    1: {fx: 1}\n    '1': {fx: 2}\n",
        *(7, 5, "effects.force_bias.1", "force_bias.1 stands twice"),
    ),
    (
        SHORT + "effects:\n  force_bias:\n    fx: 1\n    '': {fx: 2}\n",
        *(7, 5, "effects.force_bias.", "force_bias stands twice"),
    ),
    (SHORT + "effects: [viscous_drag]\n", 4, 1, "effects", "is not a mapping"),
    (SHORT + "name: [a\nb: 3\n", 5, 2, "", "not valid YAML"),
    (SHORT + "name: 'a\n", 5, 1, "", "not valid YAML"),
    (SHORT + "name: *a\n", 4, 7, "", "not valid YAML: found undefined alias 'a'"),
    (SHORT + "\tname: a\n", 4, 1, "", "not valid YAML"),
    (SHORT + "effects:\n  viscous_drag: {linear: 3.0, :\n  1.2}\n", 5, 17, "", "a key must be"),
    ("? {a: 1}\n: 2\n", 1, 1, "", "a key must be"),
    ("&a {mass: *a}\n", 1, 1, "", "is nested more than 50 deep"),
]


@pytest.mark.parametrize(
    ("text", "line", "column", "key", "words"), MISTAKES, ids=[m[3] or m[4][:20] for m in MISTAKES]
)
def test_a_mistake_is_told_with_its_place(text, line, column, key, words):
    with pytest.raises(FileError, match=re.escape(words)) as caught:
        cart_from_text(text, "carts/cart.yaml")
    error = caught.value
    assert error.place.file == "carts/cart.yaml"
    if line is not None:
        assert (error.place.line, error.place.column, error.key) == (line, column, key)
        assert str(error).startswith(f"carts/cart.yaml:{line}:{column}: {key}")


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    with pytest.raises(FileError, match="can't be read: No such file"):
        load_cart(tmp_path / "none.yaml")
    with pytest.raises(FileError, match="can't be read"):
        load_cart(tmp_path)
    (tmp_path / "latin.yaml").write_bytes("name: Käfig\n".encode("latin-1"))
    with pytest.raises(FileError, match="is not UTF-8 text"):
        load_cart(tmp_path / "latin.yaml")


def only_file_errors(text):
    try:
        cart = cart_from_text(text)
    except FileError:
        return
    assert cart_from_text(cart_text(cart)) == cart


@given(text=st.text(max_size=200))
def test_any_text_is_a_cart_or_a_file_error(text):
    only_file_errors(text)


WORDS = [
    *(
        "mass",
        "com",
        "inertia",
        "effects",
        "wheels",
        "constraints",
        "no_rotation",
        "force_bias",
        "left",
        "fx",
    ),
    *(
        ": ",
        ":\n  ",
        ", ",
        "\n",
        "\n- ",
        "[",
        "]",
        "{",
        "}",
        "? ",
        "|\n ",
        ">\n ",
        "'",
        '"',
        " #",
        "---\n",
        "...\n",
    ),
    *(
        "&a ",
        "*a",
        "<<: ",
        "!!bool ",
        "!!int ",
        "!!float ",
        "!!set ",
        "!!omap ",
        "!!binary ",
        "!!timestamp ",
        "!x ",
    ),
    *(
        "%YAML 1.1\n",
        "%TAG ! x\n",
        "1",
        "-0.5",
        "1e400",
        "0x",
        "0o8",
        "1_0",
        ".nan",
        "~",
        "2001-01-01",
        "true",
        "é",
    ),
]


@pytest.mark.parametrize("tag", ["!!set", "!!omap", "!!int", "!!float", "!!bool", "!!binary", "!!timestamp", "!!null"])
@pytest.mark.parametrize("value", ["", "x", "[x]", "{x: 1}", "{[x]: 1}"])
def test_a_tagged_value_is_a_cart_or_a_file_error(tag, value):
    for text in (
        f"{tag} {value}",
        f"mass: {tag} {value}",
        f"{SHORT}name: {tag} {value}",
        f"{tag} {value}: 3\n",
    ):
        only_file_errors(text)


@given(words=st.lists(st.sampled_from(WORDS), max_size=25))
def test_any_words_of_yaml_are_a_cart_or_a_file_error(words):
    only_file_errors("".join(words))
    only_file_errors(SHORT + "".join(words))


@given(
    cut=st.integers(0, len(CONTRACT)),
    length=st.integers(0, 12),
    words=st.lists(st.sampled_from(WORDS), max_size=3),
)
def test_a_damaged_example_is_a_cart_or_a_file_error(cut, length, words):
    only_file_errors(CONTRACT[:cut] + "".join(words) + CONTRACT[cut + length :])


@given(data=st.binary(max_size=300))
def test_any_bytes_are_a_file_error(data, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "fuzz.yaml"
    path.write_bytes(data)
    with pytest.raises(FileError):
        load_cart(path)


@pytest.mark.long
@pytest.mark.parametrize("depth", [60, 400])
@pytest.mark.parametrize(("opening", "closing"), [("[", "]"), ("{a: ", "}"), ("- ", ""), ("[{a: ", "}]")])
def test_deep_nesting_is_a_file_error(depth, opening, closing):
    with pytest.raises(FileError):
        cart_from_text("name: x\nmass: " + opening * depth + closing * depth)


def test_aliases_that_multiply_are_a_file_error():
    """The billion laughs: nine levels of nine aliases are 9⁹ values."""
    text = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n"
    text += "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 10))
    with pytest.raises(FileError, match="100000"):
        cart_from_text(SHORT + text)


def test_an_alias_is_a_value_like_another():
    assert cart_from_text("mass: &m 2.0\ncom: [0, 0]\ninertia: *m\n").inertia.about_com == 2.0
    assert cart_from_text("mass: &m 2.0\ncom: [&m 0.0, 0]\ninertia: 1\n").inertia.mass == 2.0
