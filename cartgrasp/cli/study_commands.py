"""`cartgrasp study …`: the studies. Most take a folder, a seed, and how many runs, and nothing else."""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer
from typer.models import OptionInfo

from .options import Json, Out, Seed

study = typer.Typer(help="Named, repeatable studies.", no_args_is_help=True)


@study.command("table1")
def table1(
    out: Out = Path("out/table1"),
    json: Json = False,
    seed: Seed = 0,
    rows: Annotated[str, typer.Option("--rows", help="Tests to run, such as 1,5,11 (all by default).")] = "",
) -> None:
    """All eleven rows of Table I with and without estimation, and each claim of the paper checked."""
    from . import table1 as command

    raise typer.Exit(command.run(out, json, seed, rows))


@study.command("discrepancy")
def discrepancy(
    folder: Annotated[Path, typer.Argument(help="Holds logs/NAME/run.csv and cart.yaml.", metavar="FOLDER")],
    jobs: Annotated[int | None, typer.Option("--jobs", min=1, max=64, help="Processes (else as cores).")] = None,
    json: Json = False,
) -> None:
    """The discrepancy workflow on each log of a folder, into logs/NAME/out; what has its report is left alone."""
    from . import study_discrepancy as command

    raise typer.Exit(command.run(folder, jobs, json))


def _add(name: str, about: str, runs: OptionInfo, usual: int) -> None:
    """The study in the module `name`; `runs` is the option that says how many."""

    @study.command(name, help=about)
    def command(
        out: Out = Path("out", name), json: Json = False, seed: Seed = 0, count: Annotated[int, runs] = usual
    ) -> None:
        raise typer.Exit(import_module(f".{name}", __package__).run(out, json, seed, count))


_add(
    "excitation",
    "Fixed contacts, periodic switching, and chosen contacts and motion: what each teaches, and what it costs.",
    typer.Option("--seeds", min=1, max=100, help="Runs of each way."),
    3,
)
_add(
    "robust",
    "Margins for what is not known yet of a load: how they shrink as it is learned, what they save and cost.",
    typer.Option("--seeds", min=1, max=100, help="Carts drawn."),
    8,
)
_add(
    "effort",
    "What hands pay at equal tracking error, by what is known of a load and where they hold it.",
    typer.Option("--seeds", min=1, max=100, help="Noises of each truck's sensors."),
    1,
)
_add(
    "safety",
    "Whether drawn carts, driven hard, skid or tip over: with and without the estimate and margins in the planner.",
    typer.Option("--seeds", min=1, max=1000, help="Carts drawn."),
    50,
)
_add(
    "estimators",
    "Filter, regressor, the paper's form and identify on the same logs: which is better when.",
    typer.Option("--seeds", min=2, max=100, help="Logs of each kind."),
    4,
)
_add(
    "consistency",
    "Whether the filter's errors are as large as it says, over many carts; and a wrong model, which must fail.",
    typer.Option("--runs", min=2, max=5000, help="Carts drawn."),
    500,
)
_add(
    "hardware",
    "The paper's hardware experiments on MuJoCo: straight runs, push-pull reversals on casters, heavy loads.",
    typer.Option("--runs", min=2, max=1000, help="Recordings of each experiment."),
    100,
)
_add(
    "disturbances",
    "Loads, pushes, ramps, sills and floors that no model knows, on MuJoCo, beside other controllers.",
    typer.Option("--runs", min=1, max=1000, help="Draws of each kind."),
    100,
)
