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
    """Drawn of longer steps here."""
    from docs import effect_pictures

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(effect_pictures, "PERIOD", 0.02)
        yield effect_pictures


def section(name):
    assert name in SECTIONS, f"docs/effects.md: {name} has no section; write `## {name}`, in the order of KNOWN_EFFECTS"
    return SECTIONS[name]


def test_each_effect_has_its_section():
    missing, unknown = (
        ", ".join(a.keys() - b.keys()) for a, b in ((KNOWN_EFFECTS, SECTIONS), (SECTIONS, KNOWN_EFFECTS))
    )
    assert not missing, f"docs/effects.md: no section `## NAME` of {missing}"
    assert not unknown, f"docs/effects.md: no such effect: {unknown}"
    assert list(SECTIONS) == list(KNOWN_EFFECTS), "docs/effects.md: sections have the order of KNOWN_EFFECTS"


@pytest.mark.parametrize("name", KNOWN_EFFECTS)
def test_its_parameters_have_their_units(name):
    kind = KNOWN_EFFECTS[name]
    told = re.findall(r"^\| `(\w+)` \| (\S+) \| (\S+) \|", section(name), re.MULTILINE)
    needed = [] if name == "learned_force" else [(p.name, p.unit, f"{p.typical:g}") for p in kind.parameters]
    lines = "\n".join(f"| `{parameter}` | {unit} | {usual} | what it is |" for parameter, unit, usual in needed)
    assert told == needed, (
        f"docs/effects.md: {name}: its table needs the lines\n{lines or '(none: settings say which)'}"
    )
    assert kind.signature in section(name), f"docs/effects.md: {name} lacks its signature: {kind.signature}"


@pytest.fixture(scope="module")
def without(pictures):
    """Runs of carts without an effect, of one that has viscous drag and of one that has none."""
    return {cart: pictures.run(cart) for cart in (pictures.CART, pictures.BARE)}


@pytest.mark.parametrize("name", KNOWN_EFFECTS)
def test_its_picture_is_there_and_shows_something(name, pictures, without):
    assert f"(images/effects/{name}.png)" in section(name), (
        f"docs/effects.md: {name} shows no images/effects/{name}.png"
    )
    assert name in pictures.SHOWN, f"docs/effect_pictures.py: SHOWN has no {name}"
    file = pictures.FOLDER / f"{name}.png"
    assert file.exists(), f"{file.name} is missing; draw it: python docs/effect_pictures.py {name}"
    assert file.stat().st_size > 5000, f"{file.name} shows nothing"
    bare = pictures.BARE if name == "viscous_drag" else pictures.CART
    plain, extended = without[bare], pictures.run(bare.with_effect(pictures.SHOWN[name][0]))
    moved = max(np.abs(extended.pose - plain.pose).max(), np.abs(extended.speed - plain.speed).max()) > 0.03
    felt = np.abs(extended.wrench - plain.wrench).max() > 0.3
    assert moved != felt  # what acts on the cart leaves what is given as it is, and the other way round
