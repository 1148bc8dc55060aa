"""Build the documentation site: `make site`, or `python -m deltactl.reference.site`.

Sphinx reads a copy of docs/ with the pages that are made from the code and kept nowhere: commands,
the Python interface, notebooks with their output, changes. A warning of Sphinx fails the build.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import deltactl
from deltactl.reference.commands_page import commands_page
from deltactl.reference.write import ROOT

SITE, WORK = ROOT / "build" / "site", ROOT / "build" / "site-work"
FROM_THE_TOP = {"changes.md": "CHANGELOG.md", "contributing.md": "CONTRIBUTING.md"}
"""Pages at the top of the repository, by their place on the site."""


def made_pages() -> dict[str, str]:
    """Text of each page that only the site has, by its path below docs/."""
    pages = {place: _from_the_top(name) for place, name in FROM_THE_TOP.items()}
    pages["reference/commands.md"] = commands_page()
    pages["reference/python.md"] = _python()
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        pages[f"notebooks/{path.stem}.md"] = notebook_page(path.read_text(encoding="utf-8"))
    return pages


def _from_the_top(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8").replace("](docs/", "](")


def _python() -> str:
    """The public names with their docstrings; functions before classes."""
    parts = ["# Python interface", "`import deltactl as dc`; begin with [Python](../python.md)."]
    for name in sorted(deltactl.__all__, key=lambda name: (name[0].isupper(), name)):
        kind = "autoclass" if name[0].isupper() else "autofunction"
        parts.append(f"## {name}\n\n```{{eval-rst}}\n.. {kind}:: deltactl.{name}\n```")
    return "\n\n".join(parts)


def notebook_page(text: str) -> str:
    """Cells of a notebook and what they showed, as Markdown."""
    return "\n\n".join(part for cell in json.loads(text)["cells"] for part in _cell(cell))


def _cell(cell: dict[str, Any]) -> Iterator[str]:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        yield source
        return
    yield f"```python\n{source}\n```"
    for output in cell["outputs"]:
        data = output.get("data", {})
        if shown := data.get("image/svg+xml") or data.get("text/html"):
            yield f'<div class="output">\n{_without_gaps(shown)}\n</div>'
        else:
            printed = output.get("text") or data.get("text/plain", "")
            yield f"```text\n{''.join(printed).rstrip()}\n```"


def _without_gaps(markup: str | list[str]) -> str:
    """Without empty lines, at which Markdown would end the block."""
    return "\n".join(line for line in "".join(markup).splitlines() if line.strip())


def write_source(folder: Path) -> None:
    """Put what Sphinx reads into an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder)
    for place, text in made_pages().items():
        (folder / place).write_text(text, encoding="utf-8")


def build(site: Path, work: Path) -> int:
    """Build the site; the status is that of Sphinx, 0 where it had nothing to warn of.

    work: a folder for what Sphinx reads and remembers.
    """
    from sphinx.cmd.build import build_main

    source = work / "source"
    write_source(source)
    shutil.rmtree(site, ignore_errors=True)
    options = ["-q", "-E", "-W", "--keep-going", "-d", str(work / "doctrees")]
    return build_main([*options, str(source), str(site)])


def main(site: Path = SITE, work: Path = WORK) -> int:
    """Build it where `deltactl docs` looks for it, or in the folder that is named."""
    status = build(site, work)
    print(f"{site / 'index.html'}: {'not good' if status else 'built'}")
    return status


if __name__ == "__main__":
    sys.exit(main(*map(Path, sys.argv[1:])))
