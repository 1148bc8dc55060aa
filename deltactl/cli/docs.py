"""`deltactl docs`: opens the documentation at its first page or at a named one."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.output import say
from deltactl.foundation.errors import MissingFile
from deltactl.foundation.process import IMPORT_ROOT, PACKAGE

PLACES = (PACKAGE / "site", IMPORT_ROOT / "build" / "site")
"""Where the built site may be: in an installed program, and in a clone."""
FIRST = "index"


def docs(
    page: Annotated[
        str, typer.Argument(help="Page to open, by the name of its file.", show_default=False)
    ] = FIRST,
    path_only: Annotated[
        bool, typer.Option("--path", help="Print where it is; open no browser.")
    ] = False,
) -> None:
    """Open the documentation in the browser; it needs no network.

    ```
    deltactl docs
    deltactl docs robots
    deltactl docs troubleshooting --path
    ```
    """
    found = _page_of(_site(), page)
    if path_only:
        print(found)
        return
    import webbrowser

    if webbrowser.open(found.as_uri()):
        say(f"opened {found}")
    else:
        say(f"no browser starts here; open this file in one: {found}")


def _site() -> Path:
    """The folder of the built site. Raises MissingFile, which says how to build it."""
    for place in PLACES:
        if (place / f"{FIRST}.html").is_file():
            return place.resolve()
    if (IMPORT_ROOT / "Makefile").is_file():
        raise MissingFile(f"the documentation is not built yet; type: make -C {IMPORT_ROOT} site")
    raise MissingFile(
        "this installation came without the built documentation; type 'make site' in a clone of"
        " deltactl, or install a wheel that was built after it"
    )


def _page_of(site: Path, name: str) -> Path:
    """The page's file, by its name or its path on the site. Raises MissingFile with the nearest."""
    paths = sorted(site.rglob("*.html"), key=lambda path: (len(path.parts), path))
    pages = {str(path.relative_to(site).with_suffix("")): path for path in paths}
    names = {key.rsplit("/", 1)[-1].lower(): path for key, path in reversed(pages.items())}
    wanted = name.removesuffix(".html").removesuffix(".md")
    found = pages.get(wanted) or names.get(wanted.lower())
    if found is None:
        near = difflib.get_close_matches(wanted.lower(), names, n=3) or ["commands", "python"]
        raise MissingFile(f"no page '{name}' in the documentation; there is: {', '.join(near)}")
    return found
