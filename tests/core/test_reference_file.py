"""References as files: what is written is read again to the last digit, and mistakes have a place."""

import pytest

from cartgrasp.errors import FileError
from cartgrasp.reference_file import StoredReference, Stretch, read_reference
from planning.references import PathReference

WAY = StoredReference(
    (Stretch(0.3), Stretch(1.34, 0.597015), Stretch(2.0), Stretch(1.34, -0.597015), Stretch(0.6, 0.0, 1.0)),
    (1.0, -2.0, 0.5),
    "roll: forwards # at 0.8 m/s",
)


def test_what_is_written_is_read_again(tmp_path):
    path = WAY.save(tmp_path / "next.yaml")
    text = path.read_text(encoding="utf-8")
    path.write_text(text + "  - {duration: 0.6, yaw_acceleration: -1.0}\n", encoding="utf-8")
    found = read_reference(path)
    assert found == StoredReference((*WAY.stretches, Stretch(0.6, 0.0, -1.0)), WAY.start, WAY.says)
    reference = PathReference(found.stretches, start_pose=found.start)
    assert reference.duration == pytest.approx(found.duration)
    assert reference.at(0.0).pose_sb.tolist() == [1.0, -2.0, 0.5]


def test_what_ends_at_rest_is_read_as_such(tmp_path):
    """Digits that are left out would leave 0.2 µm/s."""
    way = StoredReference((Stretch(1.2345678, 0.7123456789), Stretch(1.2345678 * 0.7123456789 / 0.9, -0.9)))
    assert read_reference(way.save(tmp_path / "next.yaml")) == way


@pytest.mark.parametrize(
    ("text", "place", "why"),
    [
        ("stretches: []", ":1:1", "stretches"),
        ("says: x", ":1:1", "is missing"),
        ("stretches:\n  - {duration: 0}", ":2", "duration"),
        ("stretches:\n  - {duration: 1, speed: 2}", ":2", "unknown key"),
        ("stretches:\n  - {duration: 1, acceleration: .nan}", ":2", "finite"),
        ("stretches:\n  - {duration: 1, acceleration: 0.5}", ":1", "they must end at rest"),
        ("stretches:\n  - {duration: 3, acceleration: 500}", ":2", "speeds are in m/s"),
        ("stretches:\n  - {duration: 0.05, acceleration: 1000}", ":2", "1000.0 is not a number from -100 to 100"),
        ("start: [0, 0, 90]\nstretches:\n  - {duration: 1}", ":1", "90 degrees are 1.571 rad"),
        ("start: [0, 0]\nstretches:\n  - {duration: 1}", ":1", "start"),
    ],
)
def test_a_mistake_has_a_place(tmp_path, text, place, why):
    path = tmp_path / "next.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        read_reference(path)
    assert f"{path}{place}" in str(caught.value)
    assert why in str(caught.value)
