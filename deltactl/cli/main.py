"""`deltactl`: the entry point. Errors of the program become one line and exit status 2."""

from __future__ import annotations

import re
import sys
from typing import Annotated, NoReturn

import typer

from deltactl.cli.called_otherwise import Commands
from deltactl.cli.mistyped import typed_command, unknown_option
from deltactl.cli.networks import collect, evaluate, reproduce, train
from deltactl.cli.recordings import correct, demo, init, prove, robotless
from deltactl.cli.robot import converting, jobs, moves, service
from deltactl.cli.services import check_runs, foxglove, web


def _show_version(asked: bool) -> None:
    if asked:
        from importlib import metadata

        print(f"deltactl {metadata.version('deltactl')}")
        raise typer.Exit


app = typer.Typer(
    name="deltactl",
    cls=Commands,
    no_args_is_help=True,
    context_settings={"help_option_names": ["--help", "-h"]},
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    help="""Finds out why a robot is not where it should be, and runs rotary delta robots.

Try it without a robot:

```
deltactl run heart.yaml            a heart on the simulated robot
deltactl check heart.yaml          what that job would do, nothing moves
deltactl report recordings/X.mcap  look at what happened
```

With a recording of your own:

```
deltactl diagnose data.csv --inspect  what it is, what to type next
```
""",
)


@app.callback()
def deltactl(
    version: Annotated[
        bool,
        typer.Option(
            "--version",
            help="Version of deltactl; `deltactl version` says more.",
            callback=_show_version,
            is_eager=True,
        ),
    ] = False,
) -> None:  # the help is that of the app
    pass


jobs.register(app)
moves.register(app)
converting.register(app)
service.register(app)
robotless.register(app)
correct.register(app)
demo.register(app)
init.register(app)
prove.register(app)
collect.register(app)
train.register(app)
evaluate.register(app)
reproduce.register(app)
web.register(app)
foxglove.register(app)
check_runs.register(app)


INTERRUPTED = 130
"""What Typer makes of Ctrl-C: 128 and the number of the signal, as shells have it."""


def main() -> None:
    """Run the command line; what the `deltactl` script calls."""
    from deltactl.foundation.errors import ConfigError, DeltactlError
    from deltactl.foundation.one_thread import one_thread_in_this_program

    one_thread_in_this_program()
    try:
        status = app(prog_name="deltactl", standalone_mode=False)
        if status == INTERRUPTED:
            print("deltactl: interrupted", file=sys.stderr)
        sys.exit(status if isinstance(status, int) else 0)
    except typer.TyperException as error:
        misused(error)
    except typer.Abort:  # a question answered by no, or by the end of the input
        print("deltactl: ended; nothing was done", file=sys.stderr)
        sys.exit(1)
    except DeltactlError as error:
        mistakes = error.args if isinstance(error, ConfigError) and error.args else (error,)
        for mistake in mistakes:
            print(f"deltactl: {one_line(mistake)}", file=sys.stderr)
        sys.exit(2)
    except BrokenPipeError:
        sys.exit(0)
    except OSError as error:  # a disk that is full, a folder that may not be written
        where = one_line(f"{error.filename}:") + " " if error.filename else ""
        print(f"deltactl: {where}{error.strerror or one_line(error)}", file=sys.stderr)
        sys.exit(2)


def misused(error: typer.TyperException) -> NoReturn:
    """One line for what is not the command's; none where its help has been printed instead."""
    said = unknown_option(error) or error.format_message()
    command = getattr(getattr(error, "ctx", None), "command_path", None) or typed_command(app)
    if said:
        said = one_line(said).rstrip(".") + _robot_file_hint(said, error)
        print(f"deltactl: {said} (see {command} --help)", file=sys.stderr)
    sys.exit(error.exit_code)


def _robot_file_hint(said: str, error: typer.TyperException) -> str:
    """How a robot file is named where somebody gave it as an argument that is not taken."""
    extra = re.match(r"Got unexpected extra argument\S* \((\S+\.ya?ml)\)", said)
    command = getattr(getattr(error, "ctx", None), "command", None)
    options = [option for one in getattr(command, "params", []) for option in one.opts]
    return (
        f"; a robot file is named with --robot {extra[1]}" if extra and "--robot" in options else ""
    )


def one_line(error: object) -> str:
    """The message without line breaks."""
    from deltactl.foundation.printable import printable

    return printable(" ".join(str(error).split()))


if __name__ == "__main__":
    main()
