"""`deltactl`: the entry point. Errors of the program become one line and exit status 2."""

from __future__ import annotations

import errno
import re
import sys
from collections.abc import Callable
from typing import Annotated, NoReturn

import typer

from deltactl.cli import collect, evaluate, reproduce, train, web
from deltactl.cli.mistyped import Commands, typed_command, unknown_option
from deltactl.cli.recordings import correct, demo, diagnose, init, prove
from deltactl.cli.robot import jobs, moves, service


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


COMMANDS: tuple[Callable[..., object], ...] = (
    *(jobs.run, jobs.follow, jobs.check, jobs.verify, jobs.report, jobs.record, jobs.export),
    *(moves.goto, moves.jog, moves.teach, moves.convert),
    *(*service.SIMPLE, service.home, service.stop, service.status, service.sensors, service.daemon),
    *(diagnose.diagnose, service.install, service.version),
    *(correct.correct, demo.demo, init.init, prove.prove),
    *(collect.collect, train.train, evaluate.evaluate, reproduce.reproduce),
    *(web.web, web.web_user, web.foxglove, service.check_runs),
)
"""In the order of the help."""
for command in COMMANDS:
    negative = {"ignore_unknown_options": True} if command is moves.goto else None
    app.command(context_settings=negative)(command)


INTERRUPTED = 130
"""What Typer makes of Ctrl-C: 128 and the number of the signal, as shells have it."""


def main() -> None:
    """Run the command line; what the `deltactl` script calls."""
    from deltactl.foundation.errors import ConfigError, DeltactlError
    from deltactl.foundation.process import one_thread_in_this_program

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
        reason = error.strerror or one_line(error)
        if error.errno in UNWRITABLE:
            reason = f"cannot be written ({reason})"
        print(f"deltactl: {where}{reason}", file=sys.stderr)
        sys.exit(2)


UNWRITABLE = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG)
"""What only happens to a file that is written."""


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
    options = [option for parameter in getattr(command, "params", []) for option in parameter.opts]
    return (
        f"; a robot file is named with --robot {extra[1]}" if extra and "--robot" in options else ""
    )


def one_line(error: object) -> str:
    """The message without line breaks."""
    from deltactl.foundation.printable import printable

    return printable(" ".join(str(error).split()))


if __name__ == "__main__":
    main()
