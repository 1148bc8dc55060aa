"""Fuzzing: python benchmarks/endurance/fuzz.py [-n 100000] [--target job] [--engine atheris].

Job and robot files, the socket, recordings (by their bytes, and well-formed ones by the values in
them), networks and tables, each with hypothesis and with atheris (make extras WITH=fuzz;
x86-64). Every input may be taken or refused with an error of ours in one line. Prints inputs,
errors by kind, the slowest input and how memory grew. Each target runs with each engine in a
process of its own: fuzz.py TARGET ENGINE INPUTS SEED OUT.
"""

from __future__ import annotations

import argparse
import collections
import importlib.util
import json
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import FrameType
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

HANG_S = 20.0
"""CPU time for one input; Python code that takes longer is interrupted."""
PER_EXAMPLE = 25
"""Inputs that hypothesis draws at a time: most of its time is its own."""


class Hang(BaseException):
    """An input took longer than HANG_S."""


class Measured:
    """Runs a target and notes errors by type, the slowest input, and memory."""

    def __init__(self, name: str, engine: str, wanted: int, out: Path):
        from benchmarks.endurance.fuzz_targets import OURS, TARGETS

        self.fuzzed = TARGETS[name]()
        self._ours = OURS
        self._name, self._engine, self._wanted, self._out = name, engine, wanted, out
        self.inputs, self.slowest_s = 0, 0.0
        self.kinds: collections.Counter[str] = collections.Counter()
        self.strange: dict[str, str] = {}
        self._early_kb = 0
        signal.signal(signal.SIGPROF, _hang)

    def one(self, data: bytes) -> None:
        """Run one input."""
        begun_s = time.process_time()
        signal.setitimer(signal.ITIMER_PROF, HANG_S)
        try:
            self.fuzzed.run(data)
            self.kinds["taken"] += 1
        except self._ours as error:
            self.kinds[type(error).__name__] += 1
            if "\n" in str(error):
                self._note("an error of several lines", data)
        except (Exception, Hang) as error:
            self._note(f"{type(error).__name__}: {error}"[:200], data)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        self.slowest_s = max(self.slowest_s, time.process_time() - begun_s)
        self.inputs += 1
        if self._engine == "atheris" and self.inputs == self._wanted // 5:
            self.begin_growth()
        if self.inputs % 1000 == 0 or self.inputs == self._wanted:
            self.write()

    def begin_growth(self) -> None:
        """Memory is looked at from here on."""
        self._early_kb = _rss_kb()

    def _note(self, what: str, data: bytes) -> None:
        self.kinds[f"NOT OURS {what.split(':')[0]}"] += 1
        if len(self.strange) < 20 and what not in self.strange:
            path = self._out.with_name(f"{self._out.stem}-{len(self.strange)}.bin")
            path.write_bytes(data)
            self.strange[what] = str(path)

    def write(self) -> None:
        """What was found so far."""
        grown_kb = _rss_kb() - self._early_kb if self._early_kb else 0
        self._out.write_text(
            json.dumps(
                {
                    "target": self._name,
                    "engine": self._engine,
                    "inputs": self.inputs,
                    "kinds": dict(self.kinds.most_common()),
                    "slowest_ms": self.slowest_s * 1e3,
                    "grown_mb": grown_kb / 1024,
                    "strange": self.strange,
                    "cpu_s": time.process_time(),
                }
            )
        )


def by_hypothesis(measured: Measured, inputs: int, seed: int) -> None:
    """Seeds changed at random, and texts and bytes of hypothesis' own."""
    from hypothesis import HealthCheck, Phase, given, settings
    from hypothesis import seed as seeded
    from hypothesis import strategies as st

    from benchmarks.endurance.fuzz_targets import mutated

    free = st.one_of(st.binary(max_size=300), st.text(max_size=200).map(_as_bytes))
    fuzzed = measured.fuzzed
    words = st.lists(st.sampled_from([*fuzzed.words, *_pieces(fuzzed.seeds)]), max_size=12)
    drawn = st.one_of(free, words.map(b"".join), words.map(b" ".join), words.map(b"\n".join))

    @seeded(seed)
    @settings(
        max_examples=-(-inputs // PER_EXAMPLE),
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(st.lists(drawn, min_size=5, max_size=5), st.randoms(use_true_random=True))
    def run(own: list[bytes], chance: random.Random) -> None:
        for data in own:
            measured.one(data)
        for _ in range(PER_EXAMPLE - len(own)):
            measured.one(mutated(fuzzed, chance))

    run()


def grow_without(measured: Measured, inputs: int, seed: int) -> None:
    """As many inputs again without the engine, whose own notes grow with every example."""
    chance = random.Random(seed)
    measured.begin_growth()
    from benchmarks.endurance.fuzz_targets import mutated

    for _ in range(inputs):
        measured.one(mutated(measured.fuzzed, chance))
    measured.write()


def by_atheris(measured: Measured, inputs: int, seed: int, folder: Path) -> None:
    """Led by coverage of our own code; ends the process."""
    import atheris

    corpus = folder / f"corpus-{measured._name}"
    corpus.mkdir(exist_ok=True)
    for number, seed_bytes in enumerate(measured.fuzzed.seeds):
        (corpus / f"seed-{number}").write_bytes(seed_bytes)
    longest = 2 * max(len(seed_bytes) for seed_bytes in measured.fuzzed.seeds)
    words = folder / f"words-{measured._name}"
    words.write_text("".join(f'"{_escaped(word)}"\n' for word in measured.fuzzed.words))
    limits = ["-timeout=60", "-rss_limit_mb=4096", "-verbosity=0", f"-max_len={longest}"]
    asked = [f"-runs={inputs}", f"-seed={seed}", f"-dict={words}", *limits, str(corpus)]
    atheris.Setup([sys.argv[0], *asked], measured.one)
    atheris.Fuzz()


def _instrument() -> None:
    """Load our modules with counters in them, before anybody else loads them."""
    import atheris

    firmware = [f"firmware_py.{part}" for part in ("daemon", "job_file", "robot_file")]
    ours = [f"deltactl.{part}" for part in ("foundation", "recording", "models.network", *firmware)]
    with atheris.instrument_imports(include=ours):
        import benchmarks.endurance.fuzz_targets  # noqa: F401


def _hang(number: int, frame: FrameType | None) -> None:
    raise Hang(f"more than {HANG_S:g} s")


def _pieces(seeds: tuple[bytes, ...]) -> list[bytes]:
    return [line for seed in seeds for line in seed.split(b"\n")[:40] if line][:100] or [b""]


def _as_bytes(text: str) -> bytes:
    return text.encode("utf-8", "surrogatepass")


def _escaped(word: bytes) -> str:
    return "".join(f"\\x{byte:02x}" for byte in word)


def _rss_kb() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4


def work(name: str, engine: str, inputs: str, seed: str, out: str) -> None:
    """Fuzz one target with one engine; what happened is written to a file as JSON."""
    if engine == "atheris":
        _instrument()
    measured = Measured(name, engine, int(inputs), Path(out))
    if engine == "atheris":
        by_atheris(measured, int(inputs), int(seed), Path(out).parent)
    else:
        by_hypothesis(measured, int(inputs), int(seed))
        grow_without(measured, int(inputs) // 5, int(seed))


TARGETS = ("job", "socket", "recording", "values", "model", "csv")
ENGINES = ("hypothesis", "atheris")
MOST_GROWTH_MB = 30.0
"""Over a fifth of the inputs again without hypothesis, whose own notes grow; with atheris
after the first fifth of them, its corpus included."""
SLOW_MS = 1000.0


def main() -> int:
    """Exit status 1 when something else than an error of ours came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-n", "--inputs", type=int, default=100_000)
    parser.add_argument("--target", action="append", choices=TARGETS)
    parser.add_argument("--engine", action="append", choices=ENGINES)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, default=Path("build/fuzz"))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    bad = False
    for target in options.target or TARGETS:
        for engine in options.engine or ENGINES:
            if importlib.util.find_spec(engine) is None:
                print(f"{target} {engine}: not installed", flush=True)
                continue
            bad |= _one(target, engine, options.inputs, options.seed, options.folder)
    return int(bad)


def _one(target: str, engine: str, inputs: int, seed: int, folder: Path) -> bool:
    out = folder / f"{target}-{engine}.json"
    out.unlink(missing_ok=True)
    words = [sys.executable, __file__, target, engine, inputs, seed, out]
    with (folder / f"{target}-{engine}.log").open("wb") as log:
        done = subprocess.run([str(word) for word in words], stdout=log, stderr=log, check=False)
    found: dict[str, Any] = json.loads(out.read_text()) if out.exists() else {}
    if not found:
        print(f"{target} {engine}: ended with {done.returncode}, see {log.name}")
        return True
    kinds = ", ".join(f"{name} {count}" for name, count in found["kinds"].items())
    print(
        f"{target:10}{engine:11}{found['inputs']:8} inputs  slowest {found['slowest_ms']:6.1f} ms"
        f"  grew {found['grown_mb']:5.1f} MB  {found['cpu_s']:5.0f} s CPU  {kinds}",
        flush=True,
    )
    for what, where in found["strange"].items():
        print(f"    NOT OURS: {what}: {where}")
    if done.returncode:
        print(f"    ended with {done.returncode}, see {log.name}")
    grew, slow = found["grown_mb"] > MOST_GROWTH_MB, found["slowest_ms"] > SLOW_MS
    return bool(found["strange"] or done.returncode or grew or slow)


if __name__ == "__main__":
    if sys.argv[1:2] and sys.argv[1] in TARGETS:
        work(*sys.argv[1:])
    else:
        sys.exit(main())
