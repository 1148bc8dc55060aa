"""What is fuzzed: each target takes bytes, and may raise errors of ours and nothing else."""

from __future__ import annotations

import atexit
import json
import os
import random
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.endurance import fuzz_values
from deltactl.firmware_py.controller.contract import JobResult, Status
from deltactl.firmware_py.daemon import protocol
from deltactl.firmware_py.daemon.actions import Actions
from deltactl.firmware_py.daemon.address import Peer
from deltactl.firmware_py.daemon.job_store import JobStore
from deltactl.firmware_py.daemon.limits import Lines
from deltactl.firmware_py.job_file import load_job
from deltactl.firmware_py.named_files import CONFIG_FOLDER, TRAINED_FOLDER
from deltactl.firmware_py.robot_file import load_robot
from deltactl.foundation.errors import DeltactlError, NotReady
from deltactl.models.network.file import checked_metadata, checksum, checksum_start
from deltactl.models.network.inverse import open_interpreter
from deltactl.models.network.structure import FlatError, check_structure
from deltactl.recording.format.configuration import RunConfiguration
from deltactl.recording.reading.reader import read_run
from deltactl.recording.tables.csv_table import read_csv
from deltactl.recording.tables.rounds import flatten
from deltactl.recording.writing.retention import confined
from deltactl.recording.writing.writer import RunRecorder

Target = Callable[[bytes], None]
OURS = (DeltactlError, protocol.BadRequest)
MB = 2**20


class Folder:
    """Scratch files in memory, overwritten again and again."""

    def __init__(self) -> None:
        place = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
        self.path = Path(tempfile.mkdtemp(prefix="deltactl-fuzz-", dir=place))
        atexit.register(shutil.rmtree, self.path, ignore_errors=True)

    def put(self, name: str, content: bytes) -> Path:
        """A file with this content."""
        path = self.path / name
        path.write_bytes(content)
        return path


@dataclass(frozen=True)
class Fuzzed:
    """A target with inputs to begin with, and words worth inserting."""

    run: Target
    seeds: tuple[bytes, ...]
    words: tuple[bytes, ...]


class NullController:
    """Refuses what needs a robot, answers the rest."""

    def __getattr__(self, name: str) -> Any:
        def refuse(*arguments: object) -> None:
            raise NotReady(f"cannot {name}: this is no robot; use one")

        return refuse

    def status(self) -> Status:
        """A robot that is off."""
        none = (0, 0, 0)
        return Status(
            "off", "", "none", True, 0.0, none, None, None, None, None, 0.0, None, (), None, "", 0
        )

    def submit(self, job: Path, record: Path | None = None, claim: object = None) -> int:
        """Reads the job, as a controller does first."""
        load_job(job)
        return 1

    def leave(self, owner: object) -> None:
        """Nothing is under way."""

    def owes(self, owner: object) -> bool:
        """Nothing is under way."""
        return False

    def result(self, job_id: int) -> JobResult | None:
        """No job ever ended."""
        return None

    def progress_count(self) -> int:
        """Alive."""
        return 1

    def stop(self, reason: str) -> None:
        """Nothing moves."""


def job_target() -> Fuzzed:
    """A job file, as text or as a robot file."""
    folder = Folder()

    def run(data: bytes) -> None:
        path = folder.put("job.yaml", data)
        if data[:1] == b"k":
            load_robot(path)
            return
        job = load_job(path)
        if job.record:
            assert confined(folder.path, job.record).parent == folder.path

    seeds = [path.read_bytes() for path in sorted(CONFIG_FOLDER.glob("*.yaml"))]
    words = [b"&a ", b"*a", b"!!python/object", b"1e999", b"0x", b"<<: ", b"---", b"\xff", b"? "]
    words += [b"record: ../x", b"repeats: ", b"{", b"[", b"\t", b"|", b"\xed\xa0\x80"]
    return Fuzzed(run, tuple(seeds), tuple(words))


def socket_target() -> Fuzzed:
    """Bytes of a client: lines, requests, what they do, and answers that must be JSON lines."""
    folder = Folder()
    jobs = folder.path / "jobs"
    actions = Actions(NullController(), JobStore(jobs), folder.path)
    peer = Peer(os.getpid(), os.getuid())

    def run(data: bytes) -> None:
        lines = Lines()
        half = len(data) // 2
        for piece in (data[:half], data[half:]):
            for line in lines.feed(piece):
                try:
                    request = protocol.parse(line)
                except protocol.BadRequest as error:
                    answer = error.answer
                else:
                    if request.do == "watch":  # the connection itself answers that
                        continue
                    answer = actions.perform(request, peer)
                said = protocol.encode(answer)
                assert said.find(b"\n") == len(said) - 1
                assert "failed inside" not in json.loads(said).get("error", {}).get("message", "")

    seeds = [
        json.dumps(
            {"id": 1, "do": do} | {name: _value(argument) for name, argument in taken.items()}
        )
        for do, taken in protocol.ARGUMENTS.items()
    ]
    job = (CONFIG_FOLDER / "heart.yaml").read_text()
    seeds.append(json.dumps({"id": "x", "do": "run", "job_text": job, "name": "heart.yaml"}))
    words = [b'"job_text"', b'"record":"../x.mcap"', b"\n", b"1e400", b"-1", b"[[[[", b"\\ud800"]
    words += [b"null", b"\xff", b'{"id":', b"9" * 40, b'"do":"stop"']
    return Fuzzed(run, tuple(f"{seed}\n".encode() for seed in seeds), tuple(words))


def recording_target() -> Fuzzed:
    """A recording, read into arrays and flattened."""
    folder = Folder()

    def run(data: bytes) -> None:
        flatten(read_run(folder.put("x.mcap", data)))

    packed = _small_recording(folder)
    words = [b"\x89MCAP0\r\n", b"\x06", b"\x05", b"zstd", b"lz4", b'"t_ns":', b"9" * 20, b"null"]
    words += [b"[[", b'"count":-1', b"\xff" * 8, b"\x00" * 8, b"/edges"]
    return Fuzzed(run, (packed, _unpacked(packed)), tuple(words))


def values_target() -> Fuzzed:
    """A well-formed recording with any values in it, up to where a diagnosis begins to fit."""
    recordings = fuzz_values.Recordings(Folder().path)
    return Fuzzed(recordings.admit, (b"", *fuzz_values.WORDS[:3]), fuzz_values.WORDS)


def model_target() -> Fuzzed:
    """A network file; with its checksum made right, so that what is behind that is reached."""

    def run(data: bytes) -> None:
        try:
            start = checksum_start(data)
            data = data[:start] + checksum(data).encode() + data[start + 64 :]
        except FlatError:
            pass
        checked_metadata(data, "fuzzed")
        check_structure(data, "fuzzed")
        open_interpreter(data)

    seeds = [path.read_bytes() for path in sorted(TRAINED_FOLDER.glob("*.tflite"))]
    return Fuzzed(run, tuple(seeds), (b"TFL3", b"\xff\xff\xff\x7f", b"\x20", b"\x00" * 4))


def csv_target() -> Fuzzed:
    """A flat table."""
    folder = Folder()

    def run(data: bytes) -> None:
        read_csv(folder.put("x.csv.gz" if data[:2] == b"\x1f\x8b" else "x.csv", data))

    rows = "\n".join(f"{k / 50},{k},{0.5 + k / 1e4},0,note" for k in range(8))
    text = f"t,steps_1,range_x,status_x,remark\n{rows}\n".encode()
    words = (b"nan", b"1e999", b'"', b",,", b"\r\n", b"inf", b"\xff", b"t,t", b"-")
    return Fuzzed(run, (text,), words)


TARGETS: dict[str, Callable[[], Fuzzed]] = {
    "job": job_target,
    "socket": socket_target,
    "recording": recording_target,
    "values": values_target,
    "model": model_target,
    "csv": csv_target,
}


def mutated(fuzzed: Fuzzed, chance: random.Random) -> bytes:
    """A seed with some bytes changed, cut out, doubled, or words put in."""
    data = bytearray(chance.choice(fuzzed.seeds))
    for _ in range(chance.choice((1, 1, 2, 4, 16))):
        at = chance.randrange(len(data) + 1)
        end = min(len(data), at + chance.choice((1, 1, 2, 4, 8, 64)))
        match chance.randrange(6):
            case 0:
                data[at:at] = chance.choice(fuzzed.words)
            case 1:
                data[at:end] = chance.choice(fuzzed.words)
            case 2:
                data[at:end] = b""
            case 3:
                data[at:at] = data[at:end]
            case 4:
                data[at:end] = chance.randbytes(end - at)
            case _:
                data = data[:at] if chance.random() < 0.1 else data
    return bytes(data)


def _value(argument: protocol.Argument) -> object:
    return "/tmp/circle.yaml" if argument.type is str else 1


def _small_recording(folder: Folder) -> bytes:
    path = folder.path / "seed.mcap"
    path.unlink(missing_ok=True)
    with RunRecorder(path, RunConfiguration("robot", "job", start_epoch_ns=10**18)) as recorder:
        _fill(recorder)
    return path.read_bytes()


def _fill(recorder: RunRecorder) -> None:
    import numpy as np

    from deltactl.drivers.ranging.contract import Gate, Reading

    recorder.settings(0, 0.002)
    for k in range(6):
        t_ns = k * 20_000_000
        recorder.target(t_ns, k, (0.0, 0.01 * k, -0.4), (k, k, k))
        recorder.commanded(t_ns, (k, k, k))
        recorder.edges(np.array([t_ns + 1000]), np.array([[1, -1, 0]], dtype=np.int8))
        recorder.truth(t_ns, (0.0, 0.0, -0.4), (0.1, 0.2, 0.3))
        recorder.event(t_ns, "note", "text")
        for axis in "xyz":
            sample = Reading(axis, t_ns, 0.5, 0, 9, 4.0, 0.1, 0.002, k + 1, Gate.GOOD)
            recorder.reading(sample)


def _unpacked(packed: bytes) -> bytes:
    """The same without compression and checksums: what is changed in it is really read."""
    import io

    from mcap.reader import make_reader

    messages = make_reader(io.BytesIO(packed)).iter_messages()
    body = [
        fuzz_values.packed(ch.topic, message.log_time, message.data) for _, ch, message in messages
    ]
    return fuzz_values.head(Folder().path) + fuzz_values.chunk(b"".join(body))
