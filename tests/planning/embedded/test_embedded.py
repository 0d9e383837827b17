"""The exported C against `WrenchPlanner`: same verdicts, same wrenches, from a compiler that forgives nothing."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.arms import Friction
from cartgrasp.errors import UsageError
from cartgrasp.joint_torques import JointTorques
from planning import WrenchPlanner
from planning.embedded import EmbeddedProblem, export_c
from planning.limits import InternalForce, Skid, TipOver

from ..drawn import StretchedArm, arm, cart, first_contacts, random_arms, random_cart, support

OURS = ("active_set", "main", "problem", "program", "proof", "wrench_planner")
JOINTS = JointTorques(np.linspace(-1, 1, 18).reshape(6, 3), [2.0, -3.0, 0.5], [20.0, 25.0, 30.0])
BOX = ((-80, -60, -40), (180, 60, 40))


def pair():
    left = arm("left", [(-0.25, 0.2, 1.0)], yaw=0.3, friction=Friction(0.6, 5), payload=3.0, joints=JOINTS)
    return [left, arm('r"i\\g/h*/t', [(-0.25, -0.2, 1.0)], moment_limit=(8, 0, 6), friction=None)]


def built(model, arms, folder, cart_limits=()):
    export_c(EmbeddedProblem.of(model, arms, first_contacts(arms), cart_limits), folder, (40.0, 0.0, 3.0))
    done = subprocess.run(["make", "-C", folder, "CFLAGS=-O1"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for name in OURS:
        assert any(f"-c {name}.c" in line and "-Wall -Wextra -Werror" in line for line in done.stdout.splitlines())
    return folder


def answers(folder, lines):
    """Status and numbers of each plan."""
    text = "\n".join(" ".join(map(repr, map(float, line))) for line in lines)
    done = subprocess.run([folder / "plan"], input=text, capture_output=True, text=True, check=True, timeout=60)
    parts = [line.split() for line in done.stdout.splitlines()]
    return [(status, np.array(numbers, dtype=float)) for status, *numbers in parts]


def questions(rng, arms, n):
    """Wrenches, of which a third come with new contacts; and the contacts that hold for each."""
    lines, contacts, points = [], [], np.array(list(first_contacts(arms).values()))
    for wrench in rng.uniform(*BOX, (n, 3)):
        is_new = rng.random() < 0.3
        points = rng.uniform(-0.5, 0.5, points.shape) if is_new else points
        lines.append([*wrench, *(points.ravel() if is_new else ())])
        contacts.append(dict(zip((a.name for a in arms), points, strict=True)))
    return lines, contacts


def disagreements(model, arms, folder, rng, n, cart_limits=()):
    """Compares n plans; gives how many were optimal, and those that C left undecided."""
    lines, contacts = questions(rng, arms, n)
    planner, optimal, undecided = WrenchPlanner(model, arms, cart_limits=cart_limits), 0, []
    for line, points, (status, numbers) in zip(lines, contacts, answers(folder, lines), strict=True):
        plan = planner.plan(line[:3], contacts=points)
        if status == "numerical":
            undecided.append(line)
            continue
        assert status == plan.status, line
        if status == "optimal":
            optimal += 1
            assert numbers[0] == pytest.approx(plan.effort, rel=1e-9, abs=1e-12)
            assert numbers[1:] == pytest.approx(np.concatenate(list(plan.wrenches.values())), abs=1e-7)
        elif not cart_limits:
            check_certificate(model, arms, points, line[:3], numbers)
    return optimal, undecided


def check_certificate(model, arms, points, wrench, numbers):
    """The direction is of unit length in the effective rows; HiGHS finds no more along it than is said."""
    direction, asked, most = numbers[:3], numbers[3], numbers[4]
    assert asked > most
    assert direction @ wrench == pytest.approx(asked, abs=1e-9 * max(1, np.abs(wrench).max()))
    assert support(model, arms, points, direction) <= most + 1e-6


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return built(cart(1, 0.1), pair(), tmp_path_factory.mktemp("export") / "planner")


@pytest.mark.long
@pytest.mark.parametrize("n", [400, pytest.param(1000, marks=pytest.mark.prove)])
def test_plans_agree(n, folder):
    optimal, undecided = disagreements(cart(1, 0.1), pair(), folder, np.random.default_rng(0), n)
    assert 0.2 * n < optimal < 0.8 * n
    assert not undecided


@pytest.mark.long
@pytest.mark.parametrize("rows", [0, 2])
def test_carts_on_casters_and_on_rails(rows, tmp_path):
    arms = [arm("left"), arm("right", [(-0.25, -0.2, 1.0)]), arm("third", [(0.5, 0.0, 1.0)], yaw=3.0)][: 1 + rows]
    place = built(cart(rows), arms, tmp_path / "c")
    optimal, undecided = disagreements(cart(rows), arms, place, np.random.default_rng(1), 100)
    assert 0 < optimal < 100
    assert not undecided


@pytest.mark.long
def test_limits_of_the_cart(tmp_path):
    """They depend on contacts by all six components, which a contact's height and the yaw enter."""
    model = cg.load_cart(Path(__file__).parents[3] / "examples" / "cart.yaml")
    limits = [Skid(0.4), TipOver(20.0), InternalForce(30.0)]
    arms = [arm("left", yaw=0.4, friction=None), arm("right", [(-0.25, -0.2, 1.0)], friction=None)]
    folder = built(model, arms, tmp_path / "c", limits)
    optimal, undecided = disagreements(model, arms, folder, np.random.default_rng(2), 300, limits)
    assert 50 < optimal < 250
    assert not undecided


@pytest.mark.prove
@pytest.mark.parametrize("seed", range(40))
def test_plans_of_random_problems_agree(seed, tmp_path, record_property):
    """C may leave a plan undecided, and says so: at most 3 in 1,000 here."""
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
    optimal, undecided = disagreements(model, arms, built(model, arms, tmp_path / "c"), rng, 1000)
    record_property("optimal", optimal)
    record_property("undecided", len(undecided))
    assert len(undecided) <= 3


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_bad_numbers_are_refused_and_change_nothing(folder, bad):
    good = [40.0, 0.0, 3.0]
    lines = [good]
    for i in range(9):
        line = [*good, -0.25, 0.1, 1.0, -0.25, -0.1, 1.0]
        line[i] = bad
        lines += [line, good]
    first, *others = answers(folder, lines)
    assert first[0] == "optimal"
    for refused, after in zip(others[::2], others[1::2], strict=True):
        assert refused[0] == "invalid_input"
        assert len(refused[1]) == 0
        assert after[0] == "optimal"
        assert after[1] == pytest.approx(first[1], rel=1e-12)


def test_what_is_too_far_or_too_strong_is_refused_as_in_python(folder):
    """A contact 50 m away is taken, and a wrench of 1e6 N; beyond both are refused."""
    planner, near = WrenchPlanner(cart(1, 0.1), pair()), [-0.25, 0.1, 1.0]
    lines = [[40.0, 0.0, 3.0, *near, x, -0.1, 1.0] for x in (50.0, 50.1, 1e5, -50.1)]
    lines += [[fx, 0.0, 0.0, *near, *near] for fx in (1e6, 1.0001e6)]
    names = [one.name for one in pair()]
    for line, (status, _) in zip(lines, answers(folder, lines), strict=True):
        plan = planner.plan_or_hold(line[:3], contacts=dict(zip(names, (line[3:6], line[6:]), strict=True)))
        assert status == plan.status
        beyond = abs(line[6]) > 50 or abs(line[0]) > 1e6
        assert (status == "invalid_input") == beyond


def test_joints_bear_what_they_do_at_the_exported_contact():
    arms = [arm("left", [(-0.25, 0.0, 1.0), (-0.5, 0.0, 1.0)], friction=None, joints=StretchedArm())]
    near, far = (EmbeddedProblem.of(cart(), arms, {"left": place}) for place in arms[0].contacts.points)
    assert near.template.limits.limits.tolist() == [40.0]
    assert far.template.limits.limits.tolist() == [20.0]


def test_arms_may_be_called_as_parts_of_the_code_are(tmp_path):
    arms = [arm(name, [(-0.25, y, 1.0)]) for name, y in (("rows", 0.2), ("names", 0.0), ("hessian", -0.2))]
    ((status, _),) = answers(built(cart(), arms, tmp_path / "c"), [(20.0, 0.0, 0.0)])
    assert status == "optimal"


def test_it_allocates_nothing(folder):
    objects = [str(path) for path in folder.rglob("*.o")]
    assert len(objects) > len(OURS)
    undefined = subprocess.run(["nm", "-u", *objects], capture_output=True, text=True, check=True).stdout
    assert "sqrt" in undefined
    assert not {"malloc", "calloc", "realloc", "free"} & set(undefined.split())


def test_lines_that_are_not_wrenches(folder):
    for text in ("1 2\n", "a b c\n", "1 2 3 4\n", "1 2 3 x\n"):
        done = subprocess.run([folder / "plan"], input=text, capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert "line 1: 3 numbers" in done.stderr
    done = subprocess.run([folder / "plan"], input="\n# nothing\n \n", capture_output=True, text=True, check=True)
    assert done.stdout == ""


def test_it_times_its_plans(folder):
    text = "40 0 3\n" * 50
    done = subprocess.run([folder / "plan", "--time"], input=text, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("50 plans, us each: median ")


def test_the_folder_stands_alone(folder):
    names = {path.name for path in folder.iterdir()}
    assert {"README.md", "Makefile", "main.c", "wrench_planner.h", "problem.h", "wrenches.txt", "osqp"} <= names
    assert "Apache License" in (folder / "osqp" / "LICENSE").read_text()
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]


def test_an_earlier_export_is_replaced_and_nothing_else(tmp_path):
    arms = pair()
    problem = EmbeddedProblem.of(cart(), arms, first_contacts(arms))
    place = tmp_path / "c"
    export_c(problem, place, (1.0, 0.0, 0.0))
    (place / "stale.o").write_text("")
    export_c(problem, place, (2.0, 0.0, 0.0))
    assert not (place / "stale.o").exists()
    assert "2.0 0.0 0.0" in (place / "wrenches.txt").read_text()
    other = tmp_path / "mine"
    other.mkdir()
    (other / "thesis.tex").write_text("all my work")
    with pytest.raises(UsageError, match="holds other files"):
        export_c(problem, other, (1.0, 0.0, 0.0))
    with pytest.raises(UsageError, match="is a file"):
        export_c(problem, other / "thesis.tex", (1.0, 0.0, 0.0))
    with pytest.raises(UsageError, match="can't be written"):
        export_c(problem, other / "thesis.tex" / "c", (1.0, 0.0, 0.0))
    assert {path.name for path in tmp_path.iterdir()} == {"c", "mine"}


def test_what_c_does_not_know_is_refused():
    arms = [arm("left", friction=Friction(0.6, "exact"))]
    with pytest.raises(UsageError, match=r"left: friction cone: .*linear limits only"):
        EmbeddedProblem.of(cart(), arms, first_contacts(arms))
    arms = [arm("left", wrench_rate=(100,) * 6)]
    with pytest.raises(UsageError, match="left: rate: C plans don't look back"):
        EmbeddedProblem.of(cart(), arms, first_contacts(arms))
