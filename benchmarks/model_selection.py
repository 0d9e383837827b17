"""`python -m benchmarks.model_selection DIR`: the rebuilt workflow on the logs of DIR (`benchmarks.sealed generate`).

Each log's report is left in DIR/logs/NAME/out-weak, so that `python -m benchmarks.sealed score DIR --reports out-weak`
judges it by the exam that `cartgrasp study discrepancy DIR` and `score DIR` give the other workflow. What has its
report is left alone.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from joblib import Parallel, delayed

from cartgrasp.cart_file import load_cart
from cartgrasp.logs import read_log
from cartgrasp.strict_json import finite
from cartgrasp.writing import write_atomically
from estimation.model_selection import diagnose

OUT = "out-weak"


def report(folder: Path) -> None:
    """Of one log, with the seconds of a core that it took."""
    out = folder / OUT
    if (out / "report.json").is_file():
        return
    start = time.process_time()
    found = diagnose(read_log(folder / "run.csv"), load_cart(folder / "cart.yaml")).report.as_dict()
    out.mkdir(exist_ok=True)
    write_atomically(out / "seconds.json", json.dumps({"seconds": time.process_time() - start}) + "\n")
    write_atomically(out / "report.json", json.dumps(finite(found), indent=1, allow_nan=False) + "\n")


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.model_selection", description="Reports of sealed logs.")
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    options = parser.parse_args()
    folders = sorted(path.parent for path in options.folder.glob("logs/*/run.csv"))
    Parallel(options.processes)(delayed(report)(folder) for folder in folders)
    print(f"{len(folders)} logs; judge them with: python -m benchmarks.sealed score {options.folder} --reports {OUT}")


if __name__ == "__main__":
    main()
