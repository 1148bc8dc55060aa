"""`deltactl`: the entry point. Errors of the program become one line and exit status 2."""

from __future__ import annotations

import errno
import re
import sys
from collections.abc import Callable
from typing import Annotated, NoReturn

import typer

from deltactl.cli import collect, docs, evaluate, reproduce, train, web
from deltactl.cli.help_screens import BY_HAND, LEARN, REPAIR, RUN, SERVICE, Command
from deltactl.cli.mistyped import Commands, Program, typed_command, unknown_option
from deltactl.cli.recordings import correct, demo, diagnose, fleet, heal, init, init_chain, prove
from deltactl.cli.robot import jobs, moves, service

app = typer.Typer(
    name="deltactl",
    cls=Program,
    no_args_is_help=True,
    invoke_without_command=True,
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
deltactl inspect data.csv          what it is, what to type next
```
""",
)


@app.callback()
def deltactl(
    ctx: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Show what is installed, and exit.")
    ] = False,
    json_out: Annotated[bool, typer.Option("--json", hidden=True)] = False,
) -> None:  # the help is that of the app
    if version:
        service.show_version(json_out)
        raise typer.Exit
    if ctx.invoked_subcommand is None:
        ctx.fail("Missing command")


Function = Callable[..., object]


def group(
    name: str, text: str | None, *functions: Function, alone: Function | None = None
) -> typer.Typer:
    """Commands under one name; `alone` is what that name does by itself."""
    made = typer.Typer(
        name=name,
        cls=Commands,
        help=text,
        no_args_is_help=alone is None,
        invoke_without_command=alone is not None,
        rich_markup_mode="markdown",
    )
    for function in functions:
        made.command(cls=Command)(function)
    if alone is not None:
        made.callback()(alone)
    return made


COMMANDS: dict[str, tuple[Function | typer.Typer, ...]] = {
    RUN: (
        *(jobs.run, jobs.check, jobs.report, jobs.export, moves.convert),
        group("job", jobs.ABOUT, jobs.follow, jobs.verify, *service.OF_JOBS, moves.teach),
    ),
    BY_HAND: (
        *(service.home, moves.goto, moves.jog),
        group("power", service.POWER, *service.OF_POWER),
        *(service.stop, service.acknowledge),
        group(
            "status",
            service.status.__doc__,
            *(service.sensors, jobs.record),
            alone=service.status,
        ),
    ),
    REPAIR: (
        group("init", init.ABOUT, init.delta, init.axis, init.sensor, init_chain.chain),
        *(diagnose.inspect, diagnose.diagnose, fleet.fleet),
        *(correct.correct, heal.heal),
        group("demo", demo.demo.__doc__, prove.prove, alone=demo.demo),
    ),
    LEARN: (
        group(
            "network",
            collect.ABOUT,
            *(collect.collect, train.train, evaluate.evaluate, reproduce.reproduce),
        ),
    ),
    SERVICE: (
        group("service", service.ABOUT, service.install, service.daemon, service.check_runs),
        group("web", web.web.__doc__, web.user, web.foxglove, alone=web.web),
        web.mcp,
        docs.docs,
    ),
}
"""By panel, in the order of the help."""
for panel, members in COMMANDS.items():
    for member in members:
        if isinstance(member, typer.Typer):
            app.add_typer(member, rich_help_panel=panel)
            Program.order.append(str(member.info.name))
        else:
            negative = {"ignore_unknown_options": True} if member is moves.goto else None
            app.command(cls=Command, context_settings=negative, rich_help_panel=panel)(member)
            Program.order.append(member.__name__)


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
    extra = re.match(r"(?:Got unexpected extra argument\S* \(|No such command ')(\S+\.ya?ml)", said)
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
