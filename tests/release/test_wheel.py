"""What is released: wheel and sdist are built, checked, installed and tried (`make release-check`).

Takes minutes and downloads what pip installs. A Python that is not on this machine is skipped,
which says nothing about it.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import zipfile
from functools import cache
from pathlib import Path

import pytest

from tests.release.project import EXTRAS, PYTHONS, ROOT, VERSION

SITE = ROOT / "build" / "site"

pytestmark = pytest.mark.release
LONGEST_S = 1500
BROKEN = ("Traceback (most recent call last)", "DeprecationWarning")


def run(*words: object, cwd: Path) -> str:
    """What a command prints, in an environment that knows nothing of this working copy."""
    apart = ("VIRTUAL_ENV", "PYTHONPATH", "PYTHONDONTWRITEBYTECODE", "PYTHONHOME")
    environment = {name: value for name, value in os.environ.items() if name not in apart}
    done = subprocess.run(
        list(map(str, words)), cwd=cwd, env=environment | {"COLUMNS": "100"},
        capture_output=True, text=True, timeout=LONGEST_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, (words, done.stdout[-2000:], done.stderr[-2000:])
    assert not any(one in done.stderr for one in BROKEN), done.stderr[-2000:]
    return done.stdout


def works(*words: str) -> bool:
    """Whether a command is there and does what it is asked."""
    return shutil.which(words[0]) is not None and (
        subprocess.run(words, capture_output=True, timeout=60, check=False).returncode == 0
    )


@cache
def interpreter(python: str) -> str | None:
    """The Python of this version: on the path, or among those that pyenv has."""
    if works(f"python{python}", "-c", "import venv"):
        return shutil.which(f"python{python}")
    if not works("pyenv", "--version"):
        return None
    listed = subprocess.run(["pyenv", "versions", "--bare"], capture_output=True, text=True)
    there = [one for one in listed.stdout.split() if one.startswith(f"{python}.")]
    if not there:
        return None
    prefix = subprocess.run(["pyenv", "prefix", there[-1]], capture_output=True, text=True)
    return f"{prefix.stdout.strip()}/bin/python"


def pip(python: str) -> list[str]:
    """The pip of an interpreter, else the first there is."""
    on_the_path = [f"{folder}/python3" for folder in os.environ["PATH"].split(os.pathsep)]
    found = next(one for one in [python, *on_the_path] if works(one, "-m", "pip", "--version"))
    return [found, "-m", "pip", "--disable-pip-version-check", "--quiet"]


def environment(folder: Path, python: str, *wanted: object) -> Path:
    """The scripts of an environment that is empty but for what pip brings with `wanted`."""
    run(python, "-m", "venv", "--without-pip", folder, cwd=folder.parent)
    own = folder / "bin" / "python"
    bound = ["-c", ROOT / "constraints.txt"]
    run(*pip(python), "--python", own, "install", *bound, *wanted, cwd=folder.parent)
    return folder / "bin"


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with wheel and sdist of what is committed; the wheel is built from the sdist."""
    folder = tmp_path_factory.mktemp("built")
    run("git", "clone", "--quiet", ROOT, folder / "clone", cwd=folder)
    if SITE.is_dir():  # of `make site`; an installed `deltactl docs` opens it
        shutil.copytree(SITE, folder / "clone" / "build" / "site")
    tools = environment(folder / "tools", interpreter("3.11") or "python3", "build", "twine")
    run(tools / "python", "-m", "build", "--outdir", folder / "dist", ".", cwd=folder / "clone")
    run(tools / "python", "-m", "twine", "check", "--strict", *(folder / "dist").iterdir(),
        cwd=folder)  # fmt: skip
    return folder / "dist"


def test_there_are_a_wheel_and_an_sdist_of_this_version(built: Path) -> None:
    names = {f"deltactl-{VERSION}-py3-none-any.whl", f"deltactl-{VERSION}.tar.gz"}
    assert {one.name for one in built.iterdir()} == names


def test_the_wheel_has_one_import_name(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {one.split("/")[0] for one in names} == {"deltactl", f"deltactl-{VERSION}.dist-info"}
    assert not [one for one in names if re.search(r"(^|/)(tests?|benchmarks)/|\.pyc$", one)]


@pytest.mark.skipif(not SITE.is_dir(), reason="make site was not typed before")
def test_the_wheel_has_the_documentation(built: Path) -> None:
    (wheel,) = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    there = {str(one.relative_to(SITE)) for one in SITE.rglob("*.html")}
    assert {f"deltactl/site/{one}" for one in there} <= names


@pytest.mark.parametrize("python", PYTHONS)
def test_the_wheel_works_in_an_empty_folder(built: Path, python: str, tmp_path: Path) -> None:
    """As `make run`, and what README shows next."""
    found = interpreter(python)
    if found is None:
        pytest.skip(f"no Python {python} on this machine: not tried")
    (wheel,) = built.glob("*.whl")
    scripts = environment(tmp_path / "venv", found, wheel)
    deltactl, empty = scripts / "deltactl", tmp_path / "empty"
    empty.mkdir()
    assert VERSION in run(deltactl, "--version", cwd=empty)
    where = "import deltactl; print(deltactl.__file__, len(deltactl.__all__))"
    assert str(tmp_path / "venv") in run(scripts / "python", "-I", "-c", where, cwd=empty)
    assert re.search(
        r"simulated truth( +\d+\.\d\d){6} +\d{4}", run(deltactl, "run", "heart.yaml", cwd=empty)
    )
    run(deltactl, "run", "circle.yaml", "--record", "r.mcap", "--report", "r.html", cwd=empty)
    run(deltactl, "diagnose", "r.mcap", "--robot", "zhao-2023.yaml", "--json", "a.json",
        "--report", "why.html", cwd=empty)  # fmt: skip
    answer = json.loads((empty / "a.json").read_text())
    assert (answer["verdict"], answer["version"]) == ("nothing_missing", VERSION)
    for page in ("r.html", "why.html"):
        assert f"deltactl {VERSION}" in (empty / page).read_text()


@pytest.mark.parametrize("python", PYTHONS)
def test_every_extra_can_be_had(built: Path, python: str, tmp_path: Path) -> None:
    """In versions that are pinned, as wheels; pip runs in that Python, whose markers count."""
    found = interpreter(python)
    if found is None:
        pytest.skip(f"no Python {python} on this machine: not tried")
    (wheel,) = built.glob("*.whl")
    wanted = f"{wheel}[{','.join(EXTRAS)}]"
    only = ("--dry-run", "--ignore-installed", "--only-binary", ":all:")
    bound = ("-c", ROOT / "constraints.txt")
    run(*pip(found), "--python", found, "install", *only, *bound, wanted, cwd=tmp_path)
