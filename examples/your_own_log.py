"""Bring your own log: a CSV with the columns of the run log, and a cart.yaml with a first guess."""

import tempfile
from pathlib import Path

import cartgrasp as cg
from cartgrasp.cli import main
from cartgrasp.studies.shopping_cart import first_guess, scenario

folder = Path(tempfile.mkdtemp())
record = scenario(quick=True, plant="model").run()  # stands in for your robot
cg.write_log(record.log, folder / "run.csv")
first_guess().save(folder / "cart.yaml")

print("cartgrasp estimate run.csv --cart cart.yaml --out series.csv")
log, cart, series = (str(folder / name) for name in ("run.csv", "cart.yaml", "series.csv"))
status = main(["estimate", log, "--cart", cart, "--out", series])
assert status == 0
assert (folder / "series.csv").read_text().startswith("t,mass,mass.std")
