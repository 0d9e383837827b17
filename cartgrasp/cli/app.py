"""The commands, and how they end: 0 it ran, 1 a promise was not met, 2 usage, 3 data, 130 interrupted."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.exceptions import TyperException
from typer.main import get_command

from planning.contact_sources.strategies import Strategy

from ..compile_notice import kernel_listener
from ..errors import CartgraspError, DataError, PlantError, printable
from .options import Accept, Coasting, Course, Json, Method, Plant, Salvage, Seed, Topics
from .output import KernelProgressLines
from .study_commands import study

app = typer.Typer(
    name="cartgrasp",
    help="Push passive carts with one or several arms, and learn the load while pushing.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "color": False if os.environ.get("NO_COLOR") else None},
)
app.add_typer(study, name="study")


@app.command()
def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for log, figures and player.")] = Path("out/demo"),
    json: Json = False,
    seed: Seed = 0,
    quick: Annotated[bool, typer.Option("--quick", metavar="", help="A shorter path, for a first look.")] = False,
) -> None:
    """Two arms push a cart of unknown load along a curved path in MuJoCo, and learn it on the way."""
    from . import demo as command

    raise typer.Exit(command.run(out, json, seed, quick))


# Many parameters: options of one command, which the contract fixes.
@app.command()
def simulate(
    cart: Annotated[Path, typer.Option("--cart", help="The true cart, cart.yaml.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for run.csv, figures and player.")] = Path("out/run"),
    guess: Annotated[Path | None, typer.Option("--guess", help="What is believed at first (else --cart).")] = None,
    path: Annotated[Course, typer.Option("--path", metavar="<name>", help="straight, curves or push-pull.")] = "curves",
    reference: Annotated[Path | None, typer.Option("--reference", help="A reference.yaml in place of --path.")] = None,
    plant: Annotated[Plant, typer.Option("--plant", metavar="<name>", help="model or mujoco.")] = "model",
    arms: Annotated[int, typer.Option("--arms", min=1, max=4, help="How many arms push.")] = 2,
    speed: Annotated[float, typer.Option("--speed", help="Forward speed, m/s.")] = 0.6,
    force_noise: Annotated[float, typer.Option("--force-noise", help="Of the force sensors, N.")] = 3.0,
    learn: Annotated[bool, typer.Option(metavar="", help="Whether to estimate the parameters.")] = True,
    contacts: Annotated[
        Strategy,
        typer.Option(
            "--contacts",
            metavar="<name>",
            help="Where hands hold: fixed, periodic, least-effort, teach or schedule; a regrasp takes its time.",
        ),
    ] = "fixed",
    skid: Annotated[
        float | None,
        typer.Option("--skid", metavar="<friction>", help="Keep the wheels from skidding on such a floor."),
    ] = None,
    tip_over: Annotated[
        float | None, typer.Option("--tip-over", metavar="<N>", help="Keep so much load on each wheel.")
    ] = None,
    confidence: Annotated[
        float | None, typer.Option("--confidence", help="With which these hold, as the filter knows the cart: 0.99.")
    ] = None,
    caution: Annotated[
        bool, typer.Option("--caution", metavar="", help="Slow down while the estimate's health is not ok.")
    ] = False,
    disturbances: Annotated[
        bool, typer.Option("--disturbances", metavar="", help="Tell and answer what pushes beside all that is known.")
    ] = False,
    seed: Seed = 0,
    json: Json = False,
) -> None:
    """A closed-loop run with a cart of yours: writes its log, figures and an animated page."""
    from . import simulate as command

    run = cart, guess, path, reference, plant, arms, speed, force_noise, learn, seed, contacts
    guards = skid, tip_over, confidence, caution, disturbances
    raise typer.Exit(command.run(command.Choice(*run, *guards), out, json))


@app.command()
def plan(
    problem: Annotated[Path, typer.Argument(help="PROBLEM.yaml: cart, wrench, arms.", metavar="PROBLEM")],
    json: Json = False,
) -> None:
    """Spread a planar wrench over the arms' contacts, with proof; says by how much it can't be done."""
    from . import plan as command

    raise typer.Exit(command.run(problem, json))


@app.command("export-c")
def export_c(
    problem: Annotated[Path, typer.Argument(help="PROBLEM.yaml: cart, wrench, arms.", metavar="PROBLEM")],
    out: Annotated[Path, typer.Option("--out", help="Folder for the C; an earlier export is replaced.")],
    json: Json = False,
) -> None:
    """Write the problem's planner as C that stands alone, for a controller in hard real time."""
    from . import export_c as command

    raise typer.Exit(command.run(problem, out, json))


@app.command()
def estimate(
    log: Annotated[Path, typer.Argument(help="A run log: .csv, .parquet, a ROS bag, or the EMPS .mat.", metavar="LOG")],
    cart: Annotated[Path | None, typer.Option("--cart", help="cart.yaml: structure and first guess.")] = None,
    method: Annotated[Method, typer.Option("--method", help="paper: its filter as printed.")] = "filter",
    out: Annotated[Path | None, typer.Option("--out", help="CSV file for the series over time.")] = None,
    topics: Topics = None,
    coasting: Coasting = False,
    accept: Accept = None,
    json: Json = False,
) -> None:
    """Learn mass, CoM, inertia and effects from a log, online, as the filter would while pushing.

    A log whose sensors are surely wrong is refused, as by `cartgrasp check`, unless that is accepted.
    """
    from . import estimate as command
    from .log_inputs import Sources

    sources = Sources((log,), cart, topics, coasting, tuple(accept or ()))
    raise typer.Exit(command.run(sources, method, out, json))


@app.command()
def check(
    log: Annotated[Path, typer.Argument(help="A run log: .csv, .parquet, a ROS bag, or the EMPS .mat.", metavar="LOG")],
    cart: Annotated[Path | None, typer.Option("--cart", help="cart.yaml: what wheels, mass and arms are like.")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="A picture of the log: .png, .svg or .pdf.")] = None,
    accept: Accept = None,
    topics: Topics = None,
    json: Json = False,
) -> None:
    """Tell what a log holds, and what its sensors seem to do: signs, axes, units, lags, rows that nothing measured.

    What learns from logs (estimate, identify, discrepancy) asks the same before it begins.
    """
    from . import check as command
    from .log_inputs import Sources

    sources = Sources((log,), cart, topics, accepted=tuple(accept or ()))
    raise typer.Exit(command.run(sources, out, json))


# Many parameters: options of one command, which the contract fixes.
@app.command()
def view(
    log: Annotated[Path, typer.Argument(help="A run log: .csv, .parquet, a ROS bag, or .mat.", metavar="RUN")],
    cart: Annotated[Path | None, typer.Option("--cart", help="cart.yaml: draws the cart, and what is learned.")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="The page (else RUN.html, beside the log).")] = None,
    png: Annotated[Path | None, typer.Option("--png", help="An overview, for a talk.")] = None,
    svg: Annotated[Path | None, typer.Option("--svg", help="The same, to edit.")] = None,
    pdf: Annotated[Path | None, typer.Option("--pdf", help="The same, for a paper.")] = None,
    gif: Annotated[Path | None, typer.Option("--gif", help="The top view, moving.")] = None,
    scene: Annotated[Path | None, typer.Option("--scene", help="In three dimensions, by MuJoCo: .png or .gif.")] = None,
    topics: Topics = None,
    json: Json = False,
) -> None:
    """Show a run: an animated page that opens offline, or figures."""
    from . import view as command

    asked = {"png": png, "svg": svg, "pdf": pdf, "gif": gif, "scene": scene, "page": out}
    raise typer.Exit(command.run(log, cart, topics, asked, json))


@app.command()
def identify(
    logs: Annotated[list[Path], typer.Argument(help="Run logs: .csv, .parquet, ROS bags, EMPS .mat.", metavar="LOG…")],
    cart: Annotated[Path | None, typer.Option("--cart", help="cart.yaml: structure and first guess.")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for cart.yaml with the values put in.")] = None,
    topics: Topics = None,
    coasting: Coasting = False,
    accept: Accept = None,
    json: Json = False,
) -> None:
    """Learn mass, CoM, inertia and effects from whole logs jointly, by least squares that keep to physical carts.

    Logs whose sensors are surely wrong are refused, as by `cartgrasp check`, unless that is accepted.
    """
    from . import identify as command
    from .log_inputs import Sources

    sources = Sources(tuple(logs), cart, topics, coasting, tuple(accept or ()))
    raise typer.Exit(command.run(sources, out, json))


# Many parameters: options of one command, which the contract fixes.
@app.command()
def discrepancy(
    logs: Annotated[list[Path], typer.Argument(help="Run logs: .csv, .parquet, ROS bags, EMPS .mat.", metavar="LOG…")],
    cart: Annotated[Path | None, typer.Option("--cart", help="cart.yaml: the model to be judged.")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the report, figures and cart.yaml.")] = None,
    follow: Annotated[Path | None, typer.Option("--follow", help="An earlier --out: its cart and logs, too.")] = None,
    next_file: Annotated[Path | None, typer.Option("--next", help="Where to write the reference to run next.")] = None,
    speed: Annotated[float, typer.Option("--speed", help="Highest speed of --next, m/s.")] = 0.8,
    duration: Annotated[float, typer.Option("--duration", help="How long --next may take, s.")] = 20.0,
    topics: Topics = None,
    coasting: Coasting = False,
    accept: Accept = None,
    json: Json = False,
) -> None:
    """Find where logs and the model disagree, name the missing effect, add it, and show the gap shrink.

    Logs whose sensors are surely wrong are refused, as by `cartgrasp check`, unless that is accepted.
    """
    from estimation.experiments.manoeuvres import Limits

    from . import discrepancy as command
    from .log_inputs import Sources

    sources = Sources(tuple(logs), cart, topics, coasting, tuple(accept or ()))
    limits = Limits(speed, duration) if next_file else None
    raise typer.Exit(command.run(sources, out, json, follow, next_file, limits))


@app.command("topics")
def list_topics(
    file: Annotated[Path, typer.Argument(help="A ROS bag, or a table: .csv, .tsv, .txt, .parquet.", metavar="FILE")],
    out: Annotated[Path | None, typer.Option("--out", help="Where to write the proposed map.")] = None,
    ask: Annotated[bool, typer.Option("--ask", metavar="", help="Ask on a terminal; write the map.")] = False,
    beside: Annotated[list[Path] | None, typer.Option("--with", help="A table of another sensor, same run.")] = None,
    salvage: Salvage = False,
    json: Json = False,
) -> None:
    """List what a bag or a table holds, and propose its map: which topics or columns are a run."""
    from . import topics as command

    raise typer.Exit(command.run(file, out, salvage, json, ask, beside or ()))


@app.command()
def convert(
    source: Annotated[Path, typer.Argument(help="A run log, or a ROS bag.", metavar="IN")],
    out: Annotated[Path, typer.Option("--out", help="The log to write: .csv, .parquet or .mcap.")],
    topics: Topics = None,
    salvage: Salvage = False,
    json: Json = False,
) -> None:
    """Write a log in another form: a bag as CSV or Parquet, a run as MCAP; with where it is from beside it."""
    from . import convert as command

    raise typer.Exit(command.run(source, out, topics, salvage, json))


@app.command()
def campaign(
    study_file: Annotated[Path, typer.Argument(help="study.yaml: runs of drawn carts, or logs.", metavar="STUDY")],
    out: Annotated[Path, typer.Option("--out", help="Folder; results that it holds are kept.")] = Path("out/campaign"),
    workers: Annotated[int | None, typer.Option("--workers", min=1, max=1024, help="Processes (else cores).")] = None,
    scheduler: Annotated[str | None, typer.Option("--scheduler", help="A Dask scheduler, tcp://HOST:8786.")] = None,
    json: Json = False,
) -> None:
    """Many closed-loop runs of drawn carts, or many logs, over cores or Dask; goes on where it stopped."""
    from . import campaign as command

    raise typer.Exit(command.run(study_file, out, workers, scheduler, json))


@app.command("warm-up")
def warm_up(json: Json = False) -> None:
    """Compile what runs at controller rate, once on a machine, so that no first call waits for it."""
    from . import warm_up as command

    raise typer.Exit(command.run(json))


@cache
def whole_command() -> Callable[..., Any]:
    """All commands as typer makes them of their signatures."""
    return get_command(app)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command; every foreseen error is one line on stderr and an exit status."""
    try:
        with kernel_listener(KernelProgressLines()):
            status = whole_command()(args=arguments, prog_name="cartgrasp", standalone_mode=False)
        return int(status or 0)
    except (typer.Abort, KeyboardInterrupt):
        return _say("interrupted", 130)
    except TyperException as error:
        return _say(_usage(error), 2)
    except (DataError, PlantError) as error:
        return _say(str(error), 3)
    except CartgraspError as error:
        return _say(str(error), 2)
    except BrokenPipeError:
        sys.stderr.close()
        return 1


def _usage(error: TyperException) -> str:
    """What typer says, and where help is."""
    context = getattr(error, "ctx", None)
    command = "cartgrasp" if context is None else context.command_path
    why = " ".join(error.format_message().split()).replace("Value error, ", "").rstrip(".") or "a command is missing"
    if likely := getattr(error, "possibilities", None):
        why = f"{error.message}. Did you mean {', '.join(likely)}?"
    return f"{why}; see `{command} --help`"


def _say(message: str, status: int) -> int:
    """One line, whatever a file name or a key in it holds."""
    print(f"cartgrasp: {printable(message)}", file=sys.stderr)
    return status
