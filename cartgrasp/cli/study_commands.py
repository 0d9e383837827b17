"""`cartgrasp study …`: the studies. Most take a folder, a seed, and how many runs, and nothing else."""

from pathlib import Path
from typing import Annotated

import typer

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


def _add(name: str, counted: tuple[str, str, int, int, int], about: str, module: str | None = None) -> None:
    """A seeded study, of a module with its name if no other is given; `counted` are seeds or runs: the word, what each
    is, the least, the most and the usual number."""
    word, each, least, most, usual = counted
    how_many = typer.Option(f"--{word}", min=least, max=most, help=each)

    @study.command(name, help=about)
    def command(
        out: Out = Path("out", name), json: Json = False, seed: Seed = 0, count: Annotated[int, how_many] = usual
    ) -> None:
        from . import seeded_studies

        raise typer.Exit(seeded_studies.run((name, module or name), word, out, json, seed, count))


_add(
    "excitation",
    ("seeds", "Runs of each way.", 1, 100, 3),
    "Fixed contacts, periodic switching, and chosen contacts and motion: what each teaches, and what it costs.",
)
_add(
    "robust",
    ("seeds", "Carts drawn.", 1, 100, 8),
    "Margins for what is not known yet of a load: how they shrink as it is learned, what they save and cost.",
    module="robust_margins",
)
_add(
    "effort",
    ("seeds", "Noises of each truck's sensors.", 1, 100, 1),
    "What hands pay at equal tracking error, by what is known of a load and where they hold it.",
)
_add(
    "safety",
    ("seeds", "Carts drawn.", 1, 1000, 50),
    "Whether drawn carts, driven hard, skid or tip over: with and without the estimate and margins in the planner.",
)
_add(
    "estimators",
    ("seeds", "Logs of each kind.", 2, 100, 4),
    "Filter, regressor, the paper's form and identify on the same logs: which is better when.",
)
_add(
    "consistency",
    ("runs", "Carts drawn.", 2, 5000, 500),
    "Whether the filter's errors are as large as it says, over many carts; and a wrong model, which must fail.",
)
_add(
    "hardware",
    ("runs", "Recordings of each experiment.", 2, 1000, 100),
    "The paper's hardware experiments on MuJoCo: straight runs, push-pull reversals on casters, heavy loads.",
)
_add(
    "disturbances",
    ("runs", "Draws of each kind.", 1, 1000, 100),
    "Loads, pushes, ramps, sills and floors that no model knows, on MuJoCo, beside other controllers.",
)
