"""Start, proof of life and end, as a service manager sees them over a real datagram socket."""

from __future__ import annotations

import os
import signal
import socket
import threading
import time
from pathlib import Path

import pytest

from deltactl.firmware_py.daemon.address import client_sockets, daemon_socket
from deltactl.firmware_py.daemon.client import daemon_answers
from deltactl.firmware_py.daemon.listener import Listener
from deltactl.firmware_py.daemon.main import _log_what_latched, run_daemon
from deltactl.firmware_py.daemon.notify import Notifier, Watchdog, check_period_s
from deltactl.firmware_py.daemon.signals import EndSignals
from deltactl.foundation.errors import ServiceError


class Manager:
    """The receiving end of sd_notify."""

    def __init__(self, address: str):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind("\0" + address[1:] if address.startswith("@") else address)
        self.socket.settimeout(5.0)

    def next(self) -> str:
        return self.socket.recv(4096).decode()

    def heard(self) -> list[str]:
        """Everything that has come so far."""
        self.socket.setblocking(False)
        found = []
        try:
            while True:
                found.append(self.next())
        except BlockingIOError:
            return found
        finally:
            self.socket.settimeout(5.0)


@pytest.fixture
def manager(tmp_path):
    one = Manager(str(tmp_path / "notify"))
    yield one
    one.socket.close()


@pytest.fixture
def notifier(manager, tmp_path):
    one = Notifier(str(tmp_path / "notify"), watchdog_s=0.09)
    yield one
    one.close()


def test_the_messages_are_those_of_sd_notify(manager, notifier):
    notifier.ready()
    notifier.status("homing\nthe arms")
    notifier.status("homing the arms")
    notifier.alive()
    notifier.stopping()
    assert manager.heard() == ["READY=1", "STATUS=homing the arms", "WATCHDOG=1", "STOPPING=1"]


def test_abstract_sockets():
    manager = Manager(f"@deltactl-test-{os.getpid()}")
    notifier = Notifier(f"@deltactl-test-{os.getpid()}")
    notifier.ready()
    assert manager.next() == "READY=1"
    notifier.close()
    manager.socket.close()


def test_the_environment_is_read_and_cleared():
    variables = {
        "NOTIFY_SOCKET": "/x",
        "WATCHDOG_USEC": "3000000",
        "WATCHDOG_PID": str(os.getpid()),
    }
    notifier = Notifier.from_environment(variables)
    assert notifier.watchdog_s == 3.0
    assert variables == {}
    notifier.close()


@pytest.mark.parametrize(
    "variables",
    [
        {},
        {"WATCHDOG_USEC": "0"},
        {"WATCHDOG_USEC": "x"},
        {"WATCHDOG_USEC": "9", "WATCHDOG_PID": "1"},
    ],
)
def test_no_watchdog_for_us(variables):
    notifier = Notifier.from_environment(variables)
    assert notifier.watchdog_s is None
    notifier.ready()  # nobody to tell, and no error
    notifier.close()


def test_a_manager_that_has_gone_does_not_matter(tmp_path, caplog):
    notifier = Notifier(str(tmp_path / "gone"))
    notifier.ready()
    assert "did not get READY=1" in caplog.text
    notifier.close()


def test_the_watchdog_is_fed_by_progress_only():
    count, serving, fed, start_s = [0], [True], [], time.monotonic()
    watchdog = Watchdog(lambda: count[0], lambda: fed.append(count[0]), lambda: serving[0])
    assert not watchdog.check()
    count[0] = 5
    assert watchdog.check()
    assert not watchdog.check()
    count[0], serving[0] = 6, False
    assert not watchdog.check()
    serving[0] = True
    assert watchdog.check()
    assert fed == [5, 6]
    assert 0.0 <= watchdog.quiet_s < time.monotonic() - start_s + 1.0


def test_the_watchdog_is_looked_after_often_enough():
    assert check_period_s(3.0) == 0.5
    assert check_period_s(0.3) == pytest.approx(0.1)
    assert check_period_s(None) == 0.5


def test_a_life_from_ready_to_sigterm(serve, manager, notifier, wait_until):
    """READY, food while there is progress, none without, STOPPING at SIGTERM, everything closed."""
    daemon = serve(start=False)
    heard: list[str] = []

    def watch_over() -> None:
        heard.append(manager.next())
        heard.append(manager.next())
        time.sleep(0.4)
        heard.extend(manager.heard())
        daemon.controller.frozen = True
        time.sleep(0.1)
        manager.heard()
        time.sleep(0.2)
        heard.append(f"while frozen: {manager.heard()}")
        os.kill(os.getpid(), signal.SIGTERM)

    manager_thread = threading.Thread(target=watch_over)
    manager_thread.start()
    with EndSignals() as signals:
        assert run_daemon(daemon.controller, daemon.server, notifier, signals) == 0
    manager_thread.join()
    assert heard[:2] == ["READY=1", "STATUS=memory (simulated): off"]
    assert heard.count("WATCHDOG=1") >= 3
    assert heard[-1] == "while frozen: []"
    assert manager.heard() == ["STOPPING=1"]
    assert daemon.controller.closed
    assert not daemon.path.exists()


def test_a_running_job_decelerates_before_the_end(serve, notifier, tmp_path):
    daemon = serve(start=False)
    long_job = tmp_path / "long.yaml"
    long_job.write_text("duration: 100")
    daemon.controller.power_on()
    daemon.controller.home()
    daemon.controller.submit(long_job)
    daemon.controller.status()
    threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGTERM)).start()
    with EndSignals() as signals:
        assert run_daemon(daemon.controller, daemon.server, notifier, signals) == 0
    assert daemon.controller.calls[-1] == "cancel"
    assert daemon.controller.jobs[0].outcome == "cancelled"


def test_a_server_that_dies_ends_the_daemon(serve, notifier):
    daemon = serve(start=False)
    threading.Timer(0.1, daemon.server._listener.wake).start()
    threading.Timer(0.1, daemon.server._closing.set).start()
    with EndSignals() as signals:
        assert run_daemon(daemon.controller, daemon.server, notifier, signals) == 1


def test_a_controller_that_cannot_go_on_ends_the_daemon(serve, notifier, caplog):
    daemon = serve(start=False)
    threading.Timer(0.1, setattr, (daemon.controller, "lost", "the pulse process ended")).start()
    with EndSignals() as signals:
        assert run_daemon(daemon.controller, daemon.server, notifier, signals) == 1
    assert daemon.controller.closed
    assert "the pulse process ended; the daemon ends" in caplog.text


def test_a_fault_is_logged_once_while_it_lasts(serve, caplog):
    controller = serve(start=False).controller
    controller.power_on()
    assert _log_what_latched(controller, "") == ""
    controller.stop("no heartbeat")
    latched = _log_what_latched(controller, "")
    assert latched == "stopped: no heartbeat"
    assert _log_what_latched(controller, latched) == latched
    assert [one.getMessage() for one in caplog.records] == [latched]


def test_the_second_daemon_is_refused(serve):
    daemon = serve()
    with pytest.raises(ServiceError, match=r"another daemon answers at .*d\.sock"):
        Listener(daemon.path)
    assert daemon_answers(daemon.path)


def test_what_a_dead_daemon_left_is_replaced(tmp_path):
    path = tmp_path / "d.sock"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as dead:
        dead.bind(str(path))
    assert not daemon_answers(path)
    listener = Listener(path)
    listener.close()
    assert not path.exists()


def test_another_programs_socket_is_left_alone(tmp_path):
    path = tmp_path / "d.sock"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as other:
        other.bind(str(path))
        other.listen()
        with pytest.raises(ServiceError, match="another daemon answers"):
            Listener(path)
    assert path.exists()


def test_what_is_no_socket_is_left_alone(tmp_path):
    path = tmp_path / "d.sock"
    path.write_text("precious")
    with pytest.raises(ServiceError, match="is no socket"):
        Listener(path)
    assert path.read_text() == "precious"


def test_bad_places_for_a_socket(tmp_path):
    with pytest.raises(ServiceError, match="107 bytes"):
        Listener(tmp_path / ("x" * 120))
    (tmp_path / "file").write_text("")
    with pytest.raises(ServiceError, match="cannot be made"):
        Listener(tmp_path / "file" / "d.sock")
    open_folder = tmp_path / "open"
    open_folder.mkdir()
    open_folder.chmod(0o777)
    with pytest.raises(ServiceError, match="others may replace"):
        Listener(open_folder / "d.sock")


def test_where_the_socket_is(monkeypatch, tmp_path):
    own = tmp_path / "own"
    own.mkdir(mode=0o700)
    for name in ("RUNTIME_DIRECTORY", "DELTACTL_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(own))
    service = Path("/run/deltactl/deltactl.sock")
    assert daemon_socket() == own / "deltactl.sock"
    assert client_sockets() == (own / "deltactl.sock", service)
    own.chmod(0o777)  # anybody could have put a socket there
    assert client_sockets() == (service,)
    monkeypatch.setenv("RUNTIME_DIRECTORY", "/run/deltactl")
    assert daemon_socket() == service
    monkeypatch.setenv("DELTACTL_SOCKET", "/elsewhere")
    assert client_sockets() == (Path("/elsewhere"),)
    assert client_sockets(Path("/given")) == (Path("/given"),)
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    monkeypatch.delenv("RUNTIME_DIRECTORY")
    assert daemon_socket() == Path(f"/tmp/deltactl-{os.getuid()}/deltactl.sock")
