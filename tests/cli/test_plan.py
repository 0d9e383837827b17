"""`cartgrasp plan` against the contract, by numpy alone; against scipy's optimum; and against odd problems."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from cartgrasp.contacts import WRENCH_NAMES

from .commands import CART, CASTERS_ALONE, PROBLEM, RAIL, problem_file, run

KEYS = {"status", "effort", "arms", "active", "residuals", "choice", "certificate", "solve_time_s"}


# --- the contract, written again ----------------------------------------------------------------------------


def effective_rows(kind, axle_x):
    """Sᵀ, by hand: what a wrench on the cart does along each free velocity."""
    if kind == "casters":
        return np.eye(3)
    rows = np.array([[1.0, 0.0, 0.0], [0.0, -axle_x, 1.0]])
    return rows[:1] if kind == "rail" else rows


def grasp(point, yaw):
    """Force first: the force turned into {b}, and its moment about {b}'s origin."""
    x, y = point[0], point[1]
    c, s = math.cos(yaw), math.sin(yaw)
    G = np.zeros((3, 6))
    G[:2, :2] = [[c, -s], [s, c]]
    G[2, :2] = x * G[1, :2] - y * G[0, :2]
    G[2, 5] = 1.0
    return G


def pyramid(mu, sides):
    """Rows A with A @ (fx, fy, fz) <= 0: the sides between generators at 2 pi k / sides from y."""
    angles = 2 * np.pi * np.arange(sides) / sides
    edges = np.column_stack([np.ones(sides), mu * np.cos(angles), mu * np.sin(angles)])
    rows = -np.cross(edges, np.roll(edges, -1, axis=0))
    return rows * -np.sign(rows @ [1.0, 0.0, 0.0])[:, None] if mu else np.zeros((0, 3))


def limit_rows(arm):
    """C and h of C F <= h for one arm."""
    box = np.array([*arm["limits"]["force"], *arm["limits"]["moment"]], dtype=float)
    rows, limits = [np.eye(6), -np.eye(6)], [box, box]
    friction = arm.get("friction")
    if friction:
        sides = pyramid(friction["mu"], friction["sides"])
        rows.append(np.hstack([sides, np.zeros((len(sides), 3))]))
        limits.append(np.zeros(len(sides)))
        rows.append(-np.eye(6)[:1])
        limits.append(np.zeros(1))
    return np.vstack(rows), np.concatenate(limits)


def stacked(problem, kind, axle_x):
    arms = problem["arms"]
    S = effective_rows(kind, axle_x)
    A = S @ np.hstack([grasp(a["contacts"][0], a["yaw"]) for a in arms])
    parts = [limit_rows(a) for a in arms]
    C = np.zeros((sum(len(h) for _, h in parts), 6 * len(arms)))
    row = 0
    for i, (rows, limits) in enumerate(parts):
        C[row : row + len(limits), 6 * i : 6 * i + 6] = rows
        row += len(limits)
    weights = np.concatenate([a["weights"] for a in arms])
    return A, S @ problem["wrench"], C, np.concatenate([h for _, h in parts]), weights


def random_problem(rng, kind):
    arms = []
    for i in range(int(rng.integers(1, 4))):
        arm = {
            "name": f"arm{i}",
            "contacts": [rng.uniform((-0.5, -0.5, 0.8), (0.5, 0.5, 1.2)).tolist()],
            "yaw": float(rng.choice([0.0, rng.uniform(-1, 1)])),
            "limits": {"force": rng.uniform(5, 60, 3).tolist(), "moment": rng.uniform(0.5, 8, 3).tolist()},
            "weights": rng.uniform(0.5, 20, 6).tolist(),
        }
        if rng.random() < 0.7:
            arm["friction"] = {"mu": float(rng.uniform(0.2, 1.0)), "sides": int(rng.choice([3, 4, 6, 8]))}
        arms.append(arm)
    wrench = rng.uniform((5, -3, -2), (40, 3, 2))
    if kind != "casters":
        wrench[1] = rng.uniform(-50, 50)  # the wheels hold what is across
    return {"wrench": wrench.tolist(), "arms": arms}


def cart_text(kind, axle_x):
    base = {"axle": CART, "rail": RAIL, "casters": CASTERS_ALONE}[kind]
    return base.replace("no_lateral_slip: {x: 0.0}", f"no_lateral_slip: {{x: {axle_x!r}}}")


def optimum(A, b, C, h, weights):
    """Least effort by scipy alone: a feasible start from linprog, then SLSQP; None if there is none."""
    first = linprog(np.zeros(A.shape[1]), C, h, A, b, bounds=(None, None), method="highs")
    if first.status == 2:
        return None
    assert first.status == 0
    scale = 1 / np.sqrt(weights)
    found = minimize(
        lambda z: z @ z,
        first.x / scale,
        jac=lambda z: 2 * z,
        method="SLSQP",
        constraints=[
            {"type": "eq", "fun": lambda z: (A * scale) @ z - b, "jac": lambda z: A * scale},
            {"type": "ineq", "fun": lambda z: h - (C * scale) @ z, "jac": lambda z: -C * scale},
        ],
        options={"ftol": 1e-13, "maxiter": 500},
    )
    assert found.status in (0, 8), found.message  # 8: no better within rounding
    return float(found.fun)


@pytest.mark.some(20)
@pytest.mark.parametrize("seed", range(51))
def test_random_problems_reach_the_optimum(capsys, tmp_path, seed):
    rng = np.random.default_rng(seed)
    kind = ("axle", "casters", "rail")[seed % 3]
    axle_x = float(rng.choice([0.0, rng.uniform(-0.3, 0.3)]))
    problem = random_problem(rng, kind)
    text = f"cart: cart.yaml\nwrench: {problem['wrench']}\narms: {json.dumps(problem['arms'])}\n"
    answer = run(capsys, "plan", problem_file(tmp_path, text, cart_text(kind, axle_x)), "--json")
    A, b, C, h, weights = stacked(problem, kind, axle_x)
    best = optimum(A, b, C, h, weights)
    document = answer.json
    assert answer.err == ""
    if best is None:
        check_infeasible(answer, A, b, C, h)
        return
    assert answer.status == 0
    has_loads = "com_height" in cart_text(kind, axle_x)
    assert set(document) == KEYS | {"margins", "cart_wrench", "wheel_side_force"} | (
        {"wheel_loads"} if has_loads else set()
    )
    if has_loads:
        carried = 9.81 * 24.0 - sum(a["wrench"][2] for a in document["arms"].values())
        assert sum(document["wheel_loads"]) == pytest.approx(carried)
    assert document["status"] == "optimal"
    assert document["certificate"] is None
    assert list(document["arms"]) == [a["name"] for a in problem["arms"]]
    F = np.concatenate([a["wrench"] for a in document["arms"].values()])
    for arm in problem["arms"]:
        assert document["arms"][arm["name"]]["contact"] == arm["contacts"][0]
    assert np.abs(A @ F - b).max() < 1e-8 * max(1, np.abs(b).max())
    assert (C @ F - h).max() < 1e-8 * max(1, np.abs(b).max())
    assert document["effort"] == pytest.approx(float(weights @ F**2), rel=1e-9)
    assert document["effort"] == pytest.approx(best, rel=1e-6, abs=1e-6)
    assert set(document["residuals"]) == {"equality", "limits", "stationarity", "gap"}
    assert set(document["choice"]) == {"bound", "gap", "solved"}
    assert document["choice"]["bound"] <= document["effort"] * (1 + 1e-9) + 1e-9
    assert 0 <= document["solve_time_s"] < 5


def check_infeasible(answer, A, b, C, h):
    document = answer.json
    assert answer.status == 1
    assert document["status"] == "infeasible"
    certificate, nearest = document["certificate"], document["nearest"]
    assert certificate["words"]
    assert certificate["limits"]
    assert certificate["asked"] > certificate["most"]
    F = np.concatenate([a["wrench"] for a in nearest["arms"].values()])
    assert (C @ F - h).max() < 1e-7 * max(1, np.abs(b).max())
    assert nearest["distance"] == pytest.approx(np.linalg.norm(A @ F - b), rel=1e-5)
    # no feasible wrench is nearer: along the line to what was asked, the arms can give no more (by linprog)
    normal = (b - A @ F) / np.linalg.norm(b - A @ F)
    farthest = linprog(-(normal @ A), C, h, bounds=(None, None), method="highs")
    assert normal @ (A @ F) == pytest.approx(-farthest.fun, rel=1e-6, abs=1e-6)


# --- odd problems -------------------------------------------------------------------------------------------


def test_infeasible_has_certificate_and_nearest(capsys, tmp_path):
    path = problem_file(tmp_path, PROBLEM.replace("[40.0, 0.0, 3.0]", "[200.0, 0.0, 0.0]"))
    answer = run(capsys, "plan", path, "--json")
    assert answer.status == 1
    assert answer.err == ""
    document = answer.json
    assert set(document) == KEYS | {"nearest"}
    assert document["effort"] is None
    assert document["arms"] == {}
    assert document["certificate"]["asked"] == pytest.approx(200)
    assert document["certificate"]["most"] == pytest.approx(120)
    assert set(document["certificate"]["limits"].values()) == {60.0}
    assert document["nearest"]["wrench"][0] == pytest.approx(120)


@pytest.mark.parametrize("cart", [CART, RAIL, CASTERS_ALONE], ids=["axle", "rail", "casters"])
@pytest.mark.parametrize("count", [1, 2, 6])
@pytest.mark.parametrize("sides", ["4", "7", "exact"])
def test_carts_and_many_arms(capsys, tmp_path, cart, count, sides):
    arms = "".join(
        f"  - name: arm{i}\n    contacts: [[-0.25, {0.1 * i - 0.25:.2f}, 1.0], [-0.3, {0.1 * i:.2f}, 1.0]]\n"
        f"    limits: {{force: [60, 60, 40], moment: [8, 8, 6]}}\n    friction: {{mu: 0.5, sides: {sides}}}\n"
        for i in range(count)
    )
    path = problem_file(tmp_path, f"cart: cart.yaml\nwrench: [20.0, 0.0, 1.0]\narms:\n{arms}", cart)
    answer = run(capsys, "plan", path, "--json")
    assert answer.status == 0
    document = answer.json
    assert document["status"] == "optimal"
    assert len(document["arms"]) == count
    for arm in document["arms"].values():
        fx, fy, fz = arm["wrench"][:3]
        assert math.hypot(fy, fz) <= 0.5 * fx + 1e-7


def test_the_zero_wrench(capsys, tmp_path):
    path = problem_file(tmp_path, PROBLEM.replace("[40.0, 0.0, 3.0]", "[0, 0.0, 0]"))
    answer = run(capsys, "plan", path, "--json")
    assert answer.status == 0
    assert answer.json["effort"] == pytest.approx(0, abs=1e-12)
    assert np.abs([a["wrench"] for a in answer.json["arms"].values()]).max() < 1e-9


def test_contacts_at_one_point_and_limits_of_zero(capsys, tmp_path):
    """Singular: two hands on one point that can't give a moment, so none at all there."""
    arm = "{{name: {}, contacts: [[0, 0, 1]], limits: {{force: [60, 60, 60], moment: [0, 0, 0]}}}}"
    arms = f"arms: [{arm.format('a')}, {arm.format('b')}]\n"
    path = problem_file(tmp_path, f"cart: cart.yaml\nwrench: [10.0, 0.0, 0.0]\n{arms}")
    answer = run(capsys, "plan", path, "--json")
    assert answer.status == 0
    assert answer.json["arms"]["a"]["wrench"][0] == pytest.approx(5)
    path = problem_file(tmp_path, f"cart: cart.yaml\nwrench: [10.0, 0.0, 1.0]\n{arms}")
    answer = run(capsys, "plan", path, "--json")
    assert answer.status == 1
    assert answer.json["status"] == "infeasible"
    assert answer.json["nearest"]["wrench"][2] == pytest.approx(0, abs=1e-7)


@pytest.mark.parametrize("value", ["1.0e-300", "1.0e-9", "1.0e6", "1.0e15", "1.0e300"])
@pytest.mark.parametrize("where", ["force: [60, 60, 40]", "moment: [8, 8, 6]"])
def test_tiny_and_huge_limits(capsys, tmp_path, where, value):
    changed = where.split(":")[0] + f": [{value}, {value}, {value}]"
    answer = run(capsys, "plan", problem_file(tmp_path, PROBLEM.replace(where, changed)), "--json")
    assert answer.status in (0, 1)
    document = answer.json
    assert document["status"] in ("optimal", "infeasible", "numerical")
    assert (document["status"] == "optimal") == (answer.status == 0)


@pytest.mark.parametrize("wrench", ["[1.0e10, 0, 0]", "[1.0, -1.0e300, 0]"])
def test_a_wrench_beyond_reason_is_a_configuration_that_cannot_be_used(capsys, tmp_path, wrench):
    path = problem_file(tmp_path, PROBLEM.replace("[40.0, 0.0, 3.0]", wrench))
    answer = run(capsys, "plan", path, "--json")
    assert answer.status == 2
    assert answer.json["status"] == "invalid_input"
    assert answer.err.startswith(f"cartgrasp: {path}: wrench: ")
    assert len(answer.err.splitlines()) == 1
    run(capsys, "plan", path).refused(2, path, "wrench")


@pytest.mark.parametrize(
    ("old", "new", "place", "why"),
    [
        ("40.0, 0.0", ".nan, 0.0", "2:10: wrench.0", "nan is not a finite number"),
        ("40.0, 0.0", "-.inf, 0.0", "2:10: wrench.0", "-inf is not a finite number"),
        ("[60, 60, 40]", "[60, .nan, 40]", "7:26: arms.0.limits.force.1", "nan is not a finite"),
        ("[60, 60, 40]", "[60, -60, 40]", "7:26: arms.0.limits.force.1", "-60 is negative"),
        ("mu: 0.6", "mu: .inf", "8:16: arms.0.friction.mu", "inf is not a finite"),
        ("name: right", "nom: right", "10:5: arms.1.n", ""),
        ("wrench:", "wrensh:", "2:1: wrensh", "did you mean wrench"),
        ("min_hand_distance: 0.1", "min_hand_distance: near", "14:1: min_hand_distance", "not a number"),
    ],
)
def test_a_mistake_is_one_line_with_its_place(capsys, tmp_path, old, new, place, why):
    assert old in PROBLEM
    path = problem_file(tmp_path, PROBLEM.replace(old, new, 1))
    run(capsys, "plan", path, "--json").refused(2, f"{path}:{place}", why)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "\n\n",
        "# nothing\n",
        "[]",
        "3",
        "cart: [",
        "cart: {",
        "\tcart: x",
        "a: b: c",
        "cart: cart.yaml\ncart: cart.yaml\n",
        "cart: *nowhere\n",
        "cart: !!python/object:os.system x\n",
        "cart: &a [*a]\nwrench: [1, 0, 0]\narms: [{name: a, contacts: [[0, 0, 1]]}]\n",
        "%YAML 9.9\n---\ncart: x\n",
        "cart: x\n---\ncart: y\n",
        "? [1, 2]\n: 3\n",
        "cart: cart.yaml\nwrench: [1, 0, 0]\narms: []\n",
        "cart: cart.yaml\nwrench: [1, 0, 0]\narms:\n",
        "cart: cart.yaml\nwrench: [1, 0, 0]\narms: [null]\n",
        "cart: cart.yaml\nwrench: [1, 0, 0]\narms: [{name: a}]\n",
        "cart: cart.yaml\nwrench: [1, 0, 0]\narms: [{name: a, contacts: []}]\n",
        "cart: cart.yaml\nwrench: [1, 0, 0]\narms: [{name: a, contacts: [[]]}]\n",
        "cart: cart.yaml\nwrench: [1, 0, 0]\narms: {name: a}\n",
        "cart: ''\nwrench: [1, 0, 0]\narms: [{name: a, contacts: [[0, 0, 1]]}]\n",
    ],
)
def test_broken_problems(capsys, tmp_path, text):
    path = problem_file(tmp_path, text)
    run(capsys, "plan", path, "--json").refused(2, tmp_path)


def test_bytes_that_are_no_text(capsys, tmp_path):
    path = problem_file(tmp_path)
    path.write_bytes(b"\xff\xfe\x00cart")
    run(capsys, "plan", path).refused(2, path, "not UTF-8")
    path.write_bytes(PROBLEM.encode().replace(b"left", b"le\x00ft"))
    run(capsys, "plan", path).refused(2, path)
    run(capsys, "plan", tmp_path).refused(2, tmp_path, "directory")


def test_hands_too_near(capsys, tmp_path):
    path = problem_file(tmp_path, PROBLEM.replace("min_hand_distance: 0.1", "min_hand_distance: 5"))
    answer = run(capsys, "plan", path, "--json")
    assert answer.status == 1
    assert answer.json["status"] == "infeasible"
    assert "distance" in answer.json["certificate"]["words"] or "m" in answer.json["certificate"]["words"]


def test_the_choice_among_contacts_is_the_best(capsys, tmp_path):
    """Each candidate alone, by hand: the planner's choice is the cheapest, and its bound says so."""
    document = run(capsys, "plan", problem_file(tmp_path), "--json").json
    efforts = {}
    for y in ("-0.20", "-0.10"):
        both = "[[-0.25, -0.20, 1.0], [-0.25, -0.10, 1.0]]"
        text = PROBLEM.replace(both, f"[[-0.25, {y}, 1.0]]")
        efforts[float(y)] = run(capsys, "plan", problem_file(tmp_path, text), "--json").json["effort"]
    best = min(efforts, key=efforts.get)
    assert document["arms"]["right"]["contact"][1] == best
    assert document["effort"] == pytest.approx(efforts[best], rel=1e-9)
    assert document["choice"]["gap"] < 1e-6
    assert document["choice"]["bound"] == pytest.approx(efforts[best], rel=1e-6)


def test_relaxed_as_the_problem_allows(tmp_path, capsys):
    """120 N is all that two hands of 60 N give; the problem says that 50 N may be missed, and then that 20 N may."""
    wide = PROBLEM.replace("[40.0, 0.0, 3.0]", "[150.0, 0.0, 0.0]") + "relax: 50\n"
    answer = run(capsys, "plan", problem_file(tmp_path, wide), "--json")
    document = answer.json
    assert answer.status == 0
    assert document["status"] == "relaxed"
    assert document["missing"]["fx"] == pytest.approx(30.0)
    assert set(document) > KEYS
    assert sum(arm["wrench"][0] for arm in document["arms"].values()) == pytest.approx(120.0)
    assert "left out of what is asked: fx 30, tau 0" in run(capsys, "plan", problem_file(tmp_path, wide)).out
    narrow = run(capsys, "plan", problem_file(tmp_path, wide.replace("relax: 50", "relax: 20")), "--json")
    assert (narrow.status, narrow.json["status"]) == (1, "infeasible")


def test_a_limit_of_the_cart_shows_in_the_answer(tmp_path, capsys):
    pulled = PROBLEM.replace("[40.0, 0.0, 3.0]", "[-60.0, 0.0, 0.0]").replace("    friction: {mu: 0.6, sides: 4}\n", "")
    limited = problem_file(tmp_path, pulled + "cart_limits: {tip_over: {least_load: 30}}\n")
    document = run(capsys, "plan", limited, "--json").json
    assert {"wheel 2 load", "wheel 3 load"} & set(document["active"])
    assert "smallest margin: " in run(capsys, "plan", limited).out


def test_margins_are_the_room_that_wrenches_leave(tmp_path, capsys):
    """By hand, from the limits in the file; what is active has none."""
    document = run(capsys, "plan", problem_file(tmp_path), "--json").json
    margins = document["margins"]
    for name, arm in document["arms"].items():
        fx, fy, fz, *_ = arm["wrench"]
        for axis, value, limit in zip(WRENCH_NAMES, arm["wrench"], [60, 60, 40, 8, 8, 6], strict=True):
            assert margins[f"{name}: {axis} upper"] == pytest.approx(limit - value, abs=1e-9)
        worst_edge = min(margins[f"{name}: friction edge {k}"] for k in range(4))
        assert worst_edge == pytest.approx((0.6 * fx - abs(fy) - abs(fz)) / math.sqrt(2), abs=1e-9)
    assert min(margins.values()) >= -1e-9
    heavy = problem_file(tmp_path, PROBLEM.replace("[40.0, 0.0, 3.0]", "[115.0, 0.0, 6.0]"))
    document = run(capsys, "plan", heavy, "--json").json
    assert document["active"]
    assert [document["margins"][name] for name in document["active"]] == pytest.approx(
        [0.0] * len(document["active"]), abs=1e-6
    )
