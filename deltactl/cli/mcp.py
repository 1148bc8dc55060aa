"""`deltactl mcp`: the tools of an assistant, over standard input and output."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from deltactl.foundation.errors import MissingFile
from deltactl.foundation.extras import needs

BY_HAND = (
    "deltactl: mcp waits for an assistant on standard input, and is started by one; its command is"
    " 'deltactl mcp --root FOLDER' (Ctrl-C ends it)"
)


def mcp(
    root: Annotated[
        Path, typer.Option(help="The one folder whose files may be read, with those below it.")
    ] = Path(),
) -> None:
    """Let an assistant inspect and diagnose recordings (Model Context Protocol).

    It speaks over standard input and output, reads files below one folder alone, and writes and
    moves nothing.

    ```
    deltactl mcp
    deltactl mcp --root ~/recordings
    ```
    """
    with needs("mcp", "mcp"):
        from deltactl.assistants.server import serve

    if not root.is_dir():
        raise MissingFile(f"--root {root}: no such folder; give the one that holds the recordings")
    if sys.stdin.isatty():
        print(BY_HAND, file=sys.stderr)
    serve(root)
