"""Answers a child's openat and device ioctls from here: a kernel's part played by a model.

Real libraries (lgpio, gpiozero, smbus2) run unmodified in the child, on machines without the
device. Uses seccomp user notification: Linux 5.14 or newer, no privileges, x86-64 or ARM64.
Does not model: poll and read on a device, so no edge events; a descriptor that the child has
closed, until its number is given again.
"""

from __future__ import annotations

import ctypes
import errno
import os
import platform
import select
import socket
import struct
import sys
import tempfile
import threading
import traceback
from fcntl import ioctl
from pathlib import Path
from typing import NamedTuple, Protocol, runtime_checkable

from deltactl.foundation.plain_file import write_whole
from deltactl.foundation.process import IMPORT_ROOT


class _Machine(NamedTuple):
    audit: int  # linux/audit.h
    seccomp: int
    openat: int
    ioctl: int


_MACHINES = {
    "x86_64": _Machine(0xC000003E, 317, 257, 16),
    "aarch64": _Machine(0xC00000B7, 277, 56, 29),
}

# linux/seccomp.h
_SET_MODE_FILTER, _NEW_LISTENER = 1, 8
_ALLOW, _NOTIFY = 0x7FFF0000, 0x7FC00000
_RECEIVE, _SEND, _ADD_FD = 0xC0502100, 0xC0182101, 0x40182103
_CONTINUE = 1
_NOTICE = struct.Struct("=QII iIQ6Q")  # id, pid, flags; nr, arch, ip, args
_REPLY = struct.Struct("=QqiI")  # id, value, error, flags
_ADD = struct.Struct("=QIIII")  # id, flags, source, target, target flags
_PR_SET_NO_NEW_PRIVS = 38


class Device(Protocol):
    """The device behind a path, or behind a descriptor that an ioctl made."""

    def ioctl(self, request: int, data: bytes) -> tuple[bytes, Device | None]:
        """Answer one ioctl: the changed argument, and a device for a descriptor that the
        kernel would put into its last four bytes. Raises OSError with the errno to report."""


class Memory(Protocol):
    """The child's memory; OSError where there is none."""

    def read(self, address: int, count: int) -> bytes:
        """Bytes from an address on."""

    def write(self, address: int, data: bytes) -> None:
        """Put bytes at an address."""


@runtime_checkable
class PointingDevice(Protocol):
    """A device whose ioctl arguments are numbers, or hold pointers (linux/i2c-dev.h)."""

    def ioctl_at(self, request: int, argument: int, memory: Memory) -> None:
        """Answer one ioctl. Raises OSError with the errno to report."""


class _ChildMemory:
    """/proc/PID/mem, for as long as a call of the child is being answered."""

    def __init__(self, pid: int):
        self._descriptor = os.open(f"/proc/{pid}/mem", os.O_RDWR | os.O_CLOEXEC)

    def __enter__(self) -> _ChildMemory:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._descriptor)

    def read(self, address: int, count: int) -> bytes:
        return os.pread(self._descriptor, count, address)

    def write(self, address: int, data: bytes) -> None:
        os.pwrite(self._descriptor, data, address)


def available() -> bool:
    """Whether this machine's kernel can do it."""
    release = tuple(int(part) for part in platform.release().split("-")[0].split(".")[:2])
    return sys.platform == "linux" and platform.machine() in _MACHINES and release >= (5, 14)


class SyscallTrap:
    """Listens for children that start through `executable`, and answers for `devices`.

    devices: by path. files: content of ordinary files, by path.
    ioctl_types: second byte of the ioctl numbers to answer (0xB4 GPIO, 0x07 I2C).
    """

    def __init__(
        self,
        devices: dict[str, Device | PointingDevice],
        ioctl_types: tuple[int, ...],
        files: dict[str, bytes] | None = None,
    ):
        self._devices, self._files = devices, files or {}
        self._folder = tempfile.TemporaryDirectory(prefix="deltactl-trap-")
        self._path = str(Path(self._folder.name) / "socket")
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.bind(self._path)
        self._socket.listen()
        self.executable = self._write_executable(ioctl_types)
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        """Take no more children; those that live stay served."""
        self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        self._folder.cleanup()

    def _write_executable(self, ioctl_types: tuple[int, ...]) -> str:
        """A replacement for the Python interpreter that puts the filter on first."""
        path = Path(self._folder.name) / "python"
        types = ",".join(str(kind) for kind in ioctl_types)
        write_whole(
            path,
            f'#!/bin/sh\nPYTHONPATH="{IMPORT_ROOT}" exec "{sys.executable}" -P '
            f'-m deltactl.drivers.fakes.syscall_trap "{self._path}" {types} "$@"\n',
            mode=0o755,
        )
        return str(path)

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            with connection:
                _, descriptors, _, _ = socket.recv_fds(connection, 1, 1)
            supervisor = _Supervisor(descriptors[0], self._devices, self._files)
            threading.Thread(target=supervisor.run, daemon=True).start()


class _Supervisor:
    """Serves one child and its descendants."""

    def __init__(
        self, listener: int, devices: dict[str, Device | PointingDevice], files: dict[str, bytes]
    ):
        self._listener, self._devices, self._files = listener, devices, files
        self._machine = _MACHINES[platform.machine()]
        self._open: dict[tuple[int, int], Device | PointingDevice] = {}
        self._process_of: dict[int, int] = {}

    def run(self) -> None:
        poll = select.poll()
        poll.register(self._listener, select.POLLIN)
        while poll.poll()[0][1] & select.POLLIN:
            notice = bytearray(_NOTICE.size)
            try:
                ioctl(self._listener, _RECEIVE, notice)
                self._answer(notice)
            except OSError:  # the child died while it waited for us
                continue
        os.close(self._listener)

    def _answer(self, notice: bytearray) -> None:
        number, thread, _, call, _, _, *arguments = _NOTICE.unpack(notice)
        pid = self._process(thread)
        value, error, flags = 0, 0, 0
        try:
            if call == self._machine.openat:
                path = _read_path(pid, arguments[1])
                if path in self._files:
                    value = self._give_file(number, self._files[path])
                elif path in self._devices:
                    value = self._give(number, pid, self._devices[path])
                else:
                    flags = _CONTINUE
            else:
                self._ioctl(number, pid, *arguments[:3])
        except OSError as failure:
            error = -(failure.errno or errno.EIO)
        except Exception:  # a fault of a model: the child must not wait for ever
            traceback.print_exc()
            error = -errno.EIO
        ioctl(self._listener, _SEND, bytearray(_REPLY.pack(number, value, error, flags)))

    def _process(self, thread: int) -> int:
        """The process of a thread: descriptors are shared by its threads."""
        if thread not in self._process_of:
            status = Path(f"/proc/{thread}/status").read_text()
            self._process_of[thread] = int(status.split("\nTgid:")[1].split()[0])
        return self._process_of[thread]

    def _ioctl(self, number: int, pid: int, descriptor: int, request: int, address: int) -> None:
        device = self._open.get((pid, descriptor))
        if device is None:
            raise OSError(errno.ENOTTY, "not one of ours")
        with _ChildMemory(pid) as memory:
            if isinstance(device, PointingDevice):
                device.ioctl_at(request & 0xFFFFFFFF, address, memory)
                return
            size = request >> 16 & 0x3FFF
            answer, made = device.ioctl(request & 0xFFFFFFFF, memory.read(address, size))
            if made is not None:
                answer = answer[:-4] + struct.pack("=i", self._give(number, pid, made))
            memory.write(address, answer)

    def _give(self, number: int, pid: int, device: Device | PointingDevice) -> int:
        """Open a descriptor in the child that represents the device."""
        given = self._install(number, os.open(os.devnull, os.O_RDWR))
        self._open[pid, given] = device
        return given

    def _give_file(self, number: int, content: bytes) -> int:
        source = os.memfd_create("trapped file")
        os.pwrite(source, content, 0)
        return self._install(number, source)

    def _install(self, number: int, source: int) -> int:
        try:
            request = bytearray(_ADD.pack(number, 0, source, 0, os.O_CLOEXEC))
            given: int = ioctl(self._listener, _ADD_FD, request)
        finally:
            os.close(source)
        return given


def _read_path(pid: int, address: int) -> str:
    with open(f"/proc/{pid}/mem", "rb", buffering=0) as memory:
        memory.seek(address)
        return memory.read(256).split(b"\0")[0].decode("utf-8", "replace")


def _filter(ioctl_types: list[int]) -> bytes:
    """Classic BPF: notify of openat, and of ioctls of these types; allow all else."""
    machine = _MACHINES[platform.machine()]
    load, equal, mask, give = 0x20, 0x15, 0x54, 0x06
    kinds = len(ioctl_types)
    program = [
        (load, 0, 0, 4),  # seccomp_data.arch
        (equal, 0, 5 + kinds, machine.audit),
        (load, 0, 0, 0),  # seccomp_data.nr
        (equal, 4 + kinds, 0, machine.openat),
        (equal, 0, 2 + kinds, machine.ioctl),
        (load, 0, 0, 24),  # seccomp_data.args[1], low half
        (mask, 0, 0, 0xFF00),
        *((equal, kinds - index, 0, kind << 8) for index, kind in enumerate(ioctl_types)),
        (give, 0, 0, _ALLOW),
        (give, 0, 0, _NOTIFY),
    ]
    return b"".join(struct.pack("=HBBI", *line) for line in program)


def _enter(path: str, ioctl_types: list[int]) -> None:
    """Put the filter on this process, and hand its listener to the trap."""
    import array  # noqa: F401 (send_fds wants it, and nobody would answer its openat yet)

    libc = ctypes.CDLL(None, use_errno=True)
    code = _filter(ioctl_types)
    text = ctypes.create_string_buffer(code, len(code))
    program = struct.pack("HxxxxxxP", len(code) // 8, ctypes.addressof(text))
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(path)
        libc.prctl(_PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0)
        seccomp = _MACHINES[platform.machine()].seccomp
        listener = libc.syscall(seccomp, _SET_MODE_FILTER, _NEW_LISTENER, program)
        if listener < 0:
            raise OSError(ctypes.get_errno(), "seccomp user notification is refused here")
        socket.send_fds(connection, [b"!"], [listener])
    os.close(listener)


if __name__ == "__main__":
    _enter(sys.argv[1], [int(kind) for kind in sys.argv[2].split(",")])
    os.execv(sys.executable, [sys.executable, *sys.argv[3:]])
