"""Campaigns: what is kept, what goes on after a kill, and the same bytes wherever the work is done."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.cart_file import cart_from_text
from cartgrasp.errors import CartgraspError, UsageError
from cartgrasp.inertia import physical_from_phi
from cartgrasp.studies.campaigns import job, workers
from cartgrasp.studies.campaigns.campaign import Results, run_campaign
from cartgrasp.studies.campaigns.drawing import Drawn, drawn_values, with_values
from cartgrasp.studies.campaigns.logs import digest
from cartgrasp.studies.campaigns.study_file import read_study
from cartgrasp.studies.campaigns.summary import ParameterSummary, RunsSummary
from cartgrasp.studies.campaigns.workers import here, on_cluster, over_cores
from cartgrasp.studies.compiled_loop.loop import covers

from ..cli.commands import CART, ROOT
from .campaign_jobs import Squares

STUDY = """\
name: few
seed: 3
runs: 3
closed_loop:
  cart: cart.yaml
  duration: 0.4
  arms:
    - {name: hand, contacts: [[-0.25, 0.0, 1.0]], limits: {force: [90, 60, 60], moment: [20, 20, 20]}}
drawn:
  mass: {uniform: [15, 45]}
  com_x: {normal: [0.3, 0.05]}
  viscous_drag.linear: {uniform: [1, 5]}
"""


def study_file(folder, text=STUDY, name="study.yaml"):
    (folder / "cart.yaml").write_text(CART, encoding="utf-8")
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def bytes_in(results):
    return {path.name: path.read_bytes() for path in results.folder.iterdir()}


# --- what is kept -------------------------------------------------------------------------------------------


def test_what_is_there_is_left_alone(tmp_path, monkeypatch):
    results, asked = Results.under(tmp_path), []

    def counted(jobs):
        asked.append(len(jobs))
        return here(jobs)

    shares = []
    found = run_campaign(Squares(4), results, counted, shares.append)
    assert [one.get("square") for one in found] == [0, 1, 4, None]
    assert found[0]["root"] is None  # NaN
    assert found[3]["failure"] == "three can't be squared"
    assert shares == [0.25, 0.5, 0.75, 1.0]
    assert run_campaign(Squares(6), results, counted)[:4] == found
    run_campaign(Squares(6), results, counted)
    assert asked == [4, 2]
    monkeypatch.setattr(job, "code_version", lambda: "other")
    assert {one.key for one in Squares(6).jobs()}.isdisjoint(path.stem for path in results.folder.iterdir())


def test_a_result_that_is_none_is_named(tmp_path):
    results = Results.under(tmp_path)
    run_campaign(Squares(1), results, here)
    path = next(results.folder.iterdir())
    path.write_text('{"square"')
    with pytest.raises(CartgraspError, match=f"{path.name}.*remove it"):
        run_campaign(Squares(1), results, here)


def test_other_code_is_refused_by_a_worker():
    with pytest.raises(UsageError, match="install the same code"):
        job.work(Squares(1).jobs()[0], "0.0.0+other")


# --- where the work is done ---------------------------------------------------------------------------------


def test_a_killed_process_costs_only_what_was_under_way(tmp_path):
    expected = Results.under(tmp_path / "here")
    run_campaign(Squares(8), expected, here)
    killed = Results.under(tmp_path / "cores")
    run_campaign(Squares(8, str(tmp_path), deadly=5), killed, over_cores(2))
    assert (tmp_path / "killed").exists()
    assert bytes_in(killed) == bytes_in(expected)


def test_processes_that_always_die_end_it(tmp_path):
    study = Squares(2, str(tmp_path / "nowhere"), deadly=1)  # there no mark can be set: OSError is the machine's
    with pytest.raises(OSError, match="nowhere"):
        run_campaign(study, Results.under(tmp_path), over_cores(2))


def started(*arguments):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *map(str, arguments)],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def waited_for(path, seconds=60.0):
    end = time.monotonic() + seconds
    while not path.exists() or not path.read_text():
        assert time.monotonic() < end, f"{path.name} has not come"
        time.sleep(0.05)


@pytest.mark.filterwarnings("default")
def test_of_two_dask_workers_one_is_killed(tmp_path):
    """The two commands of docs/campaigns.md, on this machine."""
    pytest.importorskip("distributed")
    expected = Results.under(tmp_path / "here")
    run_campaign(Squares(30), expected, here)
    file, processes = tmp_path / "scheduler.json", []
    try:
        options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", file]
        processes.append(started("scheduler", *options))
        waited_for(file)
        address = json.loads(file.read_text())["address"]
        for _ in range(2):
            options = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
            processes.append(started("worker", address, *options, "--local-directory", tmp_path / "dask"))
        found, kept = on_cluster(address), Results.under(tmp_path / "dask-results")

        def killing(jobs):
            for count, done in enumerate(found(jobs)):
                if count == 6:
                    processes[1].send_signal(signal.SIGKILL)
                yield done

        run_campaign(Squares(30, seconds=0.1), kept, killing)
        assert processes[1].wait(timeout=10) == -signal.SIGKILL
        assert bytes_in(kept) == bytes_in(expected)
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_no_scheduler_is_said(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(workers, "CONNECT_TIMEOUT", 0.2)
    with pytest.raises(UsageError, match=r"127\.0\.0\.1:9.*dask scheduler"):
        list(on_cluster("tcp://127.0.0.1:9")(Squares(1).jobs()))


def test_closed_loop_runs_are_the_same_bytes_over_cores(tmp_path):
    study = read_study(study_file(tmp_path))
    one, other = Results.under(tmp_path / "one"), Results.under(tmp_path / "other")
    found = run_campaign(study, one, here)
    run_campaign(study, other, over_cores(2))
    assert bytes_in(one) == bytes_in(other)
    masses = [run["parameters"]["mass"]["truth"] for run in found]
    assert len(set(masses)) == 3
    assert all(15 <= mass <= 45 for mass in masses)
    assert [run["drawn"]["mass"] for run in found] == pytest.approx(masses, rel=1e-12)
    assert RunsSummary.of(found).runs == 3


def test_runs_that_choose_their_contacts(tmp_path):
    """Two hands on a short path: every way ends, and a hand moves where it is told to go round."""
    one = STUDY[STUDY.index("    - {name: hand") : STUDY.index("drawn:")]
    places = {"a": "[[-0.25, 0.2, 1.0], [-0.25, 0.3, 1.0]]", "b": "[[-0.25, -0.2, 1.0], [-0.25, -0.3, 1.0]]"}
    both = "".join(one.replace("hand", name).replace("[[-0.25, 0.0, 1.0]]", at) for name, at in places.items())
    for way in ("fixed", "periodic", "least-effort", "teach", "schedule"):
        more = f"duration: 1.6\n  contacts: {way}\n  choosing: {{every: 0.5}}\n  regrasp: {{speed: 1.0, unload: 0.1}}"
        text = STUDY.replace(one, both).replace("duration: 0.4", more).replace("runs: 3", "runs: 1")
        (run,) = run_campaign(read_study(study_file(tmp_path, text)), Results.under(tmp_path / way), here)
        assert run["largest_error"] < 0.02
        assert run["regrasps"] >= (way == "periodic")
        assert run["regrasps"] <= (way != "fixed") * 4


def test_runs_with_limits_of_the_cart_caution_and_disturbances(tmp_path):
    """The hands pull back no harder than the load asked for on each wheel allows."""
    path = "path: [{duration: 0.5, acceleration: 1.2}, {duration: 0.4, acceleration: -1.5}]"
    plain = read_study(study_file(tmp_path, STUDY.replace("duration: 0.4", path)))
    guards = (
        f"{path}\n  cart_limits: {{tip_over: {{least_load: 35}}}}\n  caution: {{behind: 0.5}}\n  disturbances: true"
    )
    study = read_study(study_file(tmp_path, STUDY.replace("duration: 0.4", guards)))
    assert study.scenario.caution.behind == 0.5
    assert study.told["closed_loop"]["caution"]["behind"] == 0.5
    assert "caution" not in plain.told["closed_loop"]
    jobs = [one.jobs()[0].scenario for one in (plain, study)]
    assert [covers(one) for one in jobs] == [True, False]
    least = [min(step.plan.wheel_loads.min() for step in _steps(one)) for one in jobs]
    assert least[0] < 30.0
    assert least[1] > 35.0 - 1e-6
    (run, *_) = run_campaign(study, Results.under(tmp_path / "results"), here)
    assert run["largest_error"] < 0.05


def _steps(scenario):
    loop = scenario.build()
    while not loop.controller.is_done:
        step = loop.controller.step(loop.sensors.motion(loop.plant.time, loop.plant.motion))
        loop.controller.observe(loop.sensors.wrenches(loop.plant.time, step.given))
        loop.plant.step(step.given, loop.controller.period)
        assert (step.disturbance is not None) == scenario.disturbances
        yield step


def test_a_campaign_killed_at_any_moment_goes_on(tmp_path):
    """kill -9 while results are written: what is there is whole, and in the end all is as if nothing had been."""
    program = (
        "import sys; from pathlib import Path\n"
        "from cartgrasp.studies.campaigns.campaign import Results, run_campaign\n"
        "from cartgrasp.studies.campaigns.workers import here\n"
        "from tests.studies.campaign_jobs import Squares\n"
        "run_campaign(Squares(400), Results.under(Path(sys.argv[1])), here)\n"
    )
    expected, broken = Results.under(tmp_path / "whole"), Results.under(tmp_path / "broken")
    run_campaign(Squares(400), expected, here)
    random, kills = np.random.default_rng(0), 0
    for _ in range(3):
        process = subprocess.Popen(
            [sys.executable, "-c", program, str(tmp_path / "broken")], env={**os.environ, "PYTHONPATH": str(ROOT)}
        )
        before = len(list(broken.folder.glob("*.json")))
        while process.poll() is None and len(list(broken.folder.glob("*.json"))) < before + random.integers(1, 60):
            time.sleep(0.002)
        process.kill()
        kills += process.wait() == -signal.SIGKILL
        for path in broken.folder.glob("*.json"):
            assert path.read_bytes() == (expected.folder / path.name).read_bytes()
    assert kills
    run_campaign(Squares(400), broken, here)
    assert {k: v for k, v in bytes_in(broken).items() if not k.endswith(".part")} == bytes_in(expected)


# --- what is drawn, and what is said of it ------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32), low=st.floats(5, 50), width=st.floats(0, 50), x=st.floats(-0.5, 0.5))
def test_a_drawn_cart_has_what_was_drawn(seed, low, width, x):
    cart = cart_from_text(CART)
    drawn = (
        Drawn("mass", "uniform", (low, low + width)),
        Drawn("com_x", "normal", (x, 0.1)),
        Drawn("viscous_drag.linear", "normal", (1.0, 1.0)),
    )
    values = drawn_values(drawn, cart, np.random.default_rng(seed))
    assert low <= values["mass"] <= low + width
    assert values["viscous_drag.linear"] >= 0  # what a drag can't be is drawn again
    assert values == drawn_values(drawn, cart, np.random.default_rng(seed))
    found = with_values(cart, values)
    mass, com_x, com_y, inertia = physical_from_phi(found.inertia.phi)
    assert (mass, com_x) == pytest.approx((values["mass"], values["com_x"]), rel=1e-9, abs=1e-12)
    assert (com_y, inertia) == pytest.approx((0.0, 2.0), rel=1e-9)
    assert found.effects[0].linear == values["viscous_drag.linear"]
    assert found.effects[0].angular == 1.2


def test_laws_that_none_has():
    with pytest.raises(UsageError, match="ends below"):
        Drawn("mass", "uniform", (2.0, 1.0))
    with pytest.raises(UsageError, match="negative"):
        Drawn("mass", "normal", (2.0, -1.0))
    with pytest.raises(UsageError, match="none of 1000 draws"):
        drawn_values([Drawn("mass", "uniform", (-2.0, -1.0))], cart_from_text(CART), np.random.default_rng(0))


def test_the_summary_of_errors():
    """Against numbers worked out by hand."""
    values = ((21.0, 1.0), (19.0, 0.4), (20.0, 1.0), (24.0, 2.0))
    found = [{"value": v, "std": s, "truth": 20.0, "unit": "kg", "identifiable": v > 20} for v, s in values]
    summary = ParameterSummary.of("mass", found)
    assert summary.mean_error == pytest.approx(1.0)
    assert summary.sd_error == pytest.approx(np.sqrt((0 + 4 + 1 + 9) / 4))
    assert summary.mean_std == pytest.approx(1.1)
    assert summary.coverage == 0.75  # 19 is 2.5 deviations off
    assert summary.taught == 0.5


# --- what is refused ----------------------------------------------------------------------------------------

REFUSED = (
    ("runs: 3", "runs: 0", "study.yaml:3:1: runs"),
    ("seed: 3", "seed: -1", "study.yaml:2:1: seed"),
    ("duration: 0.4", "duraton: 0.4", "study.yaml:6:3: closed_loop.duraton: unknown key"),
    ("duration: 0.4", "path: zigzag", "study.yaml:6:3: closed_loop.path: path zigzag: unknown"),
    ("duration: 0.4", "speed: 9", "study.yaml:6:3: closed_loop.speed: speed 9"),
    ("duration: 0.4", "plant: gazebo", "study.yaml:6:3: closed_loop.plant"),
    ("duration: 0.4", "known: [tail]", "study.yaml:6:3: closed_loop.known: prior: known: there is no 'tail'"),
    ("duration: 0.4", "path: [{duration: 1, acceleration: 1}]", "closed_loop.path: reference: ends with u = 1"),
    ("duration: 0.4", "period: 1.0e-9", "study.yaml:6:3: closed_loop.period: a run of 1.91e+10 periods"),
    ("duration: 0.4", "period: 100", "study.yaml:6:3: closed_loop.period: a run of 0.191 periods"),
    ("duration: 0.4", "period: 0.6", "study.yaml:6:3: closed_loop.period: period: 0.6 is not a number from 0 to 0.5"),
    ("duration: 0.4", "gains: {along: 1.0e+13}", "study.yaml:6:3: closed_loop.gains: gains: along"),
    ("duration: 0.4", "switching: {every: 4000}", "study.yaml:6:15: closed_loop.switching.every: choosing: every"),
    ("duration: 0.4", "duration: 0.001", "study.yaml:6:3: closed_loop.duration: a run of 0.1 periods"),
    ("duration: 0.4", "duration: 1.0e+9", "study.yaml:6:3: closed_loop.duration: a run of 1e+11 periods"),
    (
        "duration: 0.4",
        "path: [{duration: 1.0e+9}]",
        "study.yaml:6:3: closed_loop.path: stretch: duration: 1000000000.0 is not a number",
    ),
    ("duration: 0.4", "path: [{duration: -1}]", "closed_loop.path.0.duration: -1 is not > 0"),
    ("duration: 0.4", "plant_timestep: 1.0e-9", "study.yaml:6:3: closed_loop.plant_timestep: is below a 1,000th"),
    ("[[-0.25, 0.0, 1.0]]", "[[1.0e+300, 0, 0]]", "closed_loop.arms.0.contacts: contacts: (1e+300"),
    ("duration: 0.4", "contacts: best", "study.yaml:6:3: closed_loop.contacts"),
    (
        "duration: 0.4",
        "regrasp: {speed: 1}",
        "6:3: closed_loop.regrasp: is for `contacts`, which is missing",
    ),
    ("duration: 0.4", "contacts: teach\n  switching: {every: 2}", "7:3: closed_loop.switching: stands beside"),
    (
        "duration: 0.4",
        "contacts: teach\n  choosing: {asked: {com_z: 0.1}}",
        "closed_loop.choosing: choosing: asked: there is no 'com_z'; did you mean com_",
    ),
    (
        "duration: 0.4\n  arms:\n    - {name: hand, contacts: [[-0.25, 0.0, 1.0]]",
        "contacts: schedule\n  arms:\n    - {name: hand, segment: [[-0.25, 0.0, 1.0], [-0.25, 0.1, 1.0]]",
        "closed_loop.contacts: schedule: arm hand may hold anywhere on a segment",
    ),
    ("duration: 0.4", "confidence: 0.99", "6:3: closed_loop.confidence: is of `cart_limits`, which are missing"),
    ("duration: 0.4", "cart_limits: {skid: {}}", "closed_loop.cart_limits.skid.friction: is missing"),
    ("duration: 0.4", "caution: {pace: {tired: 0.5}}", "6:3: closed_loop.caution: caution: pace: there is no 'tired'"),
    (
        "duration: 0.4",
        "disturbances: true\n  estimation: paper",
        "6:3: closed_loop.disturbances: the paper's filter tells none",
    ),
    ("cart: cart.yaml", "cart: 3", "study.yaml:5:3: closed_loop.cart: 3 is neither"),
    ("cart: cart.yaml", "cart: {mass: 3}", "study.yaml:5:9: closed_loop.cart.com: is missing"),
    ("cart: cart.yaml", "cart: no.yaml", "no.yaml: can't be read"),
    ("name: hand", "name: a.b", "study.yaml:8:8: closed_loop.arms.0.name"),
    ("mass: {uniform", "weight: {uniform", "study.yaml:10:3: drawn.weight: is no parameter of the cart"),
    ("mass: {uniform: [15, 45]}", "mass: {uniform: [45, 15]}", "drawn.mass.uniform: uniform: [45, 15] ends below"),
    ("mass: {uniform: [15, 45]}", "mass: {}", "study.yaml:10:3: drawn.mass: needs one law"),
    ("mass: {uniform: [15, 45]}", "mass: {uniform: [15]}", "drawn.mass.uniform"),
    ("seed: 3", "logs: {files: [a.csv], cart: cart.yaml}", "either `closed_loop`"),
)


@pytest.mark.parametrize(("old", "new", "said"), REFUSED, ids=[new for _, new, _ in REFUSED])
def test_a_mistake_is_refused_with_its_place(tmp_path, old, new, said):
    assert old in STUDY
    with pytest.raises(UsageError) as refused:
        read_study(study_file(tmp_path, STUDY.replace(old, new)))
    assert said in str(refused.value)


def test_logs_that_are_not_there(tmp_path):
    text = "logs:\n  files: ['*.csv']\n  cart: cart.yaml\n"
    with pytest.raises(UsageError, match=r"study.yaml:2:11: logs.files.0: \*.csv: there is no such file"):
        read_study(study_file(tmp_path, text))
    with pytest.raises(UsageError, match=r"logs.files.0: \*\*a: Invalid pattern"):
        read_study(study_file(tmp_path, text.replace("*.csv", "**a")))
    (tmp_path / "a.csv").touch()
    path = study_file(tmp_path, text + "drawn: {mass: {uniform: [1, 2]}}\n")
    with pytest.raises(UsageError, match="drawn: is for runs"):
        read_study(path)


def test_a_folder_that_is_no_log_is_not_walked_through(tmp_path):
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "a" / "b" / "large").touch()
    empty = digest(tmp_path / "nothing")
    assert digest(tmp_path / "a") == empty
    (tmp_path / "a" / "run_0.mcap").touch()
    assert digest(tmp_path / "a") != empty


def test_the_key_follows_what_matters(tmp_path):
    first = read_study(study_file(tmp_path)).jobs()
    more = read_study(study_file(tmp_path, STUDY.replace("runs: 3", "runs: 5").replace("few", "more"))).jobs()
    assert [one.key for one in first] == [one.key for one in more[:3]]
    assert len({one.key for one in more}) == 5
    for old, new in (("seed: 3", "seed: 4"), ("0.4", "0.5"), ("[15, 45]", "[15, 46]"), ("[90,", "[91,")):
        other = read_study(study_file(tmp_path, STUDY.replace(old, new))).jobs()
        assert {one.key for one in other}.isdisjoint(one.key for one in more), new
    (tmp_path / "cart.yaml").write_text(CART.replace("com_height: 0.45", "com_height: 0.46"))
    assert read_study(Path(tmp_path / "study.yaml")).jobs()[0].key != first[0].key
