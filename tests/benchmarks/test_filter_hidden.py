"""What the online filter says of carts that lack something: of two logs, as the table of many is made."""

from benchmarks.filter_hidden import said, table
from benchmarks.sealed.generate import generate


def test_what_lacks_friction_is_not_sure_of_a_wrong_mass(tmp_path):
    names = generate(tmp_path, ["nothing", "rolling_resistance"], range(1), "straight")
    found = [said(name, tmp_path) for name in names]
    rows = table(found).splitlines()
    assert len(rows) == 2 + 2 + 1
    for one in found:
        assert one.off_by_five <= one.off_by_three <= one.taught <= one.ok <= 1.0
        assert one.off_by_five < 0.05
