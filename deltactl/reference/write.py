"""Write the pages and schemas: `python -m deltactl.reference.write`."""

from __future__ import annotations

from pathlib import Path

from deltactl.foundation.plain_file import write_whole
from deltactl.reference.pages import ROOT, pages
from deltactl.reference.schemas import schemas


def made() -> dict[Path, str]:
    """Every file and its text."""
    texts = {ROOT / "docs" / "reference" / name: text for name, text in pages().items()}
    return texts | {ROOT / "deltactl" / "schemas" / name: text for name, text in schemas().items()}


def main() -> None:
    """Write all of them."""
    for path, text in made().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
        print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
