"""The page of effects has all of them, with their parameters and units, and a picture in which each does something."""

from __future__ import annotations

import re

import numpy as np
import pytest

from cartgrasp.effects import KNOWN_EFFECTS

from ..cli.commands import ROOT

PAGE = (ROOT / "docs" / "effects.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## )", PAGE, re.MULTILINE | re.DOTALL))


@pytest.fixture(scope="module")
def pictures():
    from docs import effect_pictures

    return effect_pictures


def test_each_effect_has_its_section():
    assert list(SECTIONS) == list(KNOWN_EFFECTS)


@pytest.mark.parametrize("name", KNOWN_EFFECTS)
def test_its_parameters_have_their_units(name):
    told = re.findall(r"^\| `(\w+)` \| (\S+) \| (\S+) \|", SECTIONS[name], re.MULTILINE)
    if name == "learned_force":
        assert told == []  # its settings say which it has
    else:
        assert told == [(p.name, p.unit, f"{p.typical:g}") for p in KNOWN_EFFECTS[name].parameters]
    assert KNOWN_EFFECTS[name].signature in SECTIONS[name]


@pytest.fixture(scope="module")
def without(pictures):
    """Runs of carts without an effect, of one that has viscous drag and of one that has none."""
    return {cart: pictures.run(cart) for cart in (pictures.CART, pictures.BARE)}


@pytest.mark.parametrize("name", KNOWN_EFFECTS)
def test_its_picture_is_there_and_shows_something(name, pictures, without):
    assert f"(images/effects/{name}.png)" in SECTIONS[name]
    assert (pictures.FOLDER / f"{name}.png").stat().st_size > 5000
    bare = pictures.BARE if name == "viscous_drag" else pictures.CART
    plain, extended = without[bare], pictures.run(bare.with_effect(pictures.SHOWN[name][0]))
    moved = max(np.abs(extended.pose - plain.pose).max(), np.abs(extended.speed - plain.speed).max()) > 0.03
    felt = np.abs(extended.wrench - plain.wrench).max() > 0.3
    assert moved != felt  # what acts on the cart leaves what is given as it is, and the other way round
