"""Requests through real sockets: what the client asks is what the controller does."""

from __future__ import annotations

import itertools
import os
import stat
from pathlib import Path

import pytest

from deltactl.firmware_py.controller.contract import HomeSeen
from deltactl.firmware_py.daemon.client import Client, daemon_answers
from deltactl.firmware_py.daemon.line import Line
from deltactl.foundation.errors import (
    ConfigError,
    MissingFile,
    NotReady,
    RecordingError,
    ServiceError,
)


def test_a_job_from_power_on_to_its_result(serve, job, wait_until):
    daemon = serve()
    with daemon.client() as client:
        client.power_on()
        assert client.home(3.0) == HomeSeen("taken on trust to 3 degrees", "look")
        number = client.submit(job)
        assert client.result(number) is None
        wait_until(lambda: client.result(number) is not None)
        assert client.result(number).outcome == "done"
        client.power_off()
    assert daemon.controller.calls == ["on", "home", "run", "off"]


def test_status_arrives_whole(serve):
    with serve().client() as client:
        status = client.status()
        assert (status.state, status.robot, status.counts) == ("off", "memory", (1, 2, 3))
        assert status.position_m == (0.0, None, -0.4)  # what is not finite is null in JSON
        assert status.sensors[0].distance_m == 0.4
        assert client.sensors() == status.sensors


def test_refusals_keep_their_class_and_words(serve, job):
    with serve().client() as client:
        with pytest.raises(NotReady, match="cannot home: the robot is off; 'deltactl power on'"):
            client.home()
        with pytest.raises(NotReady, match="cannot run: the robot is off"):
            client.submit(job)


def test_who_asked_is_noted(serve):
    daemon = serve()
    with daemon.client() as client:
        client.power_on()
        client.status()
        client.stop("finger")
    mine = f"uid {os.getuid()} (process {os.getpid()})"
    assert daemon.notes == [f"on asked for by {mine}", f"stop finger asked for by {mine}"]


def test_pause_resume_cancel_acknowledge(serve, tmp_path):
    long_job = tmp_path / "long.yaml"
    long_job.write_text("duration: 100")
    with serve().client() as client:
        client.power_on()
        client.home()
        number = client.submit(long_job)
        client.pause()
        assert client.status().state == "paused"
        client.resume()
        client.cancel()
        assert client.result(number).outcome == "cancelled"
        client.stop("enough")
        assert (client.status().state, client.status().why) == ("stopped", "enough")
        client.acknowledge()
        assert client.status().state == "unhomed"


def test_the_second_job_is_queued(serve, job):
    with serve().client() as first, Client(first.path) as second:
        first.power_on()
        first.home()
        one, two = first.submit(job), second.submit(job)
        assert (one, two) == (1, 2)
        assert second.status().queued == ("circle",)


def test_a_job_the_daemon_cannot_read_is_sent(serve, tmp_path, monkeypatch):
    daemon = serve()
    hidden = tmp_path / "my heart é.yaml"
    hidden.write_text("duration: 0.1")
    _hide(monkeypatch, hidden)
    with daemon.client() as client:
        client.power_on()
        client.home()
        client.submit(hidden)
    stored = daemon.controller.jobs[0].path
    assert stored.parent == tmp_path / "jobs"
    assert stored.name.startswith("my-heart-")
    assert stored.read_text() == "duration: 0.1"


def test_a_mistake_in_a_sent_job_names_the_users_file(serve, tmp_path, monkeypatch):
    hidden = tmp_path / "wrong.yaml"
    hidden.write_text("length: 3")
    _hide(monkeypatch, hidden)
    with serve().client() as client:
        client.power_on()
        client.home()
        with pytest.raises(ConfigError, match=rf"^{hidden}:1: 'duration' is missing$"):
            client.submit(hidden)


def test_a_job_that_nobody_can_read(serve, tmp_path):
    with serve().client() as client, pytest.raises(MissingFile, match=r"none\.yaml: the daemon"):
        client.submit(tmp_path / "none.yaml")


@pytest.mark.parametrize(
    ("name", "complaint"),
    [("relative.yaml", "whole path"), ("/etc/passwd", "named"), ("/tmp/../etc/x.yaml", "cannot")],
)
def test_jobs_that_are_no_job_files(serve, name, complaint):
    answer = serve().raw().ask(id=1, do="run", job=name)
    assert complaint in answer["error"]["message"]


def test_a_pipe_as_job_holds_nobody_up(serve, tmp_path):
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    with serve().client() as client, pytest.raises(ConfigError, match="no plain file"):
        client.submit(pipe)


def test_the_recording_goes_where_it_was_asked_for(serve, job, tmp_path):
    daemon = serve()
    with daemon.client() as client:
        client.power_on()
        client.home()
        client.submit(job, tmp_path / "run.mcap")
        client.submit(job, Path("other.mcap"))
    records = [one.record for one in daemon.controller.jobs]
    assert records == [tmp_path / "run.mcap", tmp_path / "other.mcap"]


@pytest.mark.parametrize(
    "wanted",
    [
        "/etc/cron.d/x.mcap",
        "../x.mcap",
        "sub/x.mcap",
        "sub/../../x.mcap",
        "..",
        ".hidden.mcap",
        "a" * 300,
        "{folder}/../x.mcap",
        "{folder}/link/x.mcap",
    ],
)
def test_a_recording_stays_in_its_folder(serve, job, tmp_path, wanted):
    (tmp_path / "link").symlink_to("/tmp")
    daemon = serve()
    with daemon.client() as client:
        client.power_on()
        client.home()
        with pytest.raises(RecordingError, match=r"plain name|may have 200"):
            client.submit(job, Path(wanted.replace("{folder}", str(tmp_path))))
    assert daemon.controller.jobs == []


def test_unknown_jobs_have_no_result(serve):
    with serve().client() as client, pytest.raises(ServiceError, match="knows no job 7"):
        client.result(7)


def test_version_and_ping(serve):
    with serve().client() as client:
        assert client.version()["protocol"] == 1
        assert client.progress_count() < client.progress_count()


def test_the_stream_keeps_its_rate(serve):
    daemon = serve()
    with daemon.client() as client:
        stream = client.watch(20.0)
        times_s = [next(stream).time_s for _ in range(5)]
        stream.close()
    gaps_s = [later - sooner for sooner, later in itertools.pairwise(times_s)]
    assert sum(gaps_s) > 0.18
    assert min(gaps_s) > 0.02


def test_a_client_speaks_while_it_watches(serve):
    raw = serve().raw()
    assert raw.ask(id="w", do="watch", rate_hz=20) == {"id": "w", "ok": True}
    assert raw.receive()["status"]["state"] == "off"
    raw.send(b'{"id": 5, "do": "on"}\n')
    seen = [raw.receive() for _ in range(6)]
    assert {"id": 5, "ok": True} in seen
    assert seen[-1]["status"]["state"] == "unhomed"


def test_requests_may_be_ended_before_the_answers_come(serve):
    """As `echo ... | socat - UNIX:...` does it."""
    daemon = serve(home_s=0.3)
    with daemon.client() as client:
        client.power_on()
    raw = daemon.raw()
    raw.send(b'{"id": 1, "do": "home"}\n')
    raw.socket.shutdown(1)
    answer = raw.receive()
    assert (answer["id"], answer["ok"]) == (1, True)
    assert raw.receive() is None


def test_nobody_there(tmp_path):
    nowhere = tmp_path / "none.sock"
    assert not daemon_answers(nowhere)
    with pytest.raises(ServiceError, match=r"no daemon answers at .*systemctl start deltactl"):
        Client(nowhere)


def test_somebody_there(serve):
    assert daemon_answers(serve().path)


def test_the_daemon_ends_under_a_client(serve):
    daemon = serve()
    with daemon.client() as client:
        client.status()
        daemon.close()
        with pytest.raises(ServiceError, match="ended the connection"):
            client.status()


def test_a_daemon_that_hangs_is_said_to_hang(serve):
    daemon = serve()
    with (
        Client(daemon.path, quick_s=0.2) as client,
        daemon.controller.lock,
        pytest.raises(ServiceError, match="does not answer in time"),
    ):
        _in_thread(client.status)


def test_the_socket_is_for_owner_and_group(serve):
    mode = stat.S_IMODE(serve().path.stat().st_mode)
    assert mode == 0o660


def test_answers_of_given_up_requests_are_skipped(serve):
    daemon = serve(home_s=0.3)
    with daemon.client() as client:
        client.power_on()
    line = Line(daemon.path, 30.0)
    with pytest.raises(ServiceError, match="in time"):
        line.ask({"do": "home"}, 0.05)
    answer = line.ask({"do": "version"}, 30.0)
    assert answer["protocol"] == 1
    line.close()


def _in_thread(call):
    """Run in another thread, so that a lock held here is a lock held by somebody else."""
    import concurrent.futures

    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        return pool.submit(call).result()


def _hide(monkeypatch, hidden: Path) -> None:
    """Make a file unreadable for the daemon only, as ProtectHome= does."""
    real = Path.stat

    def look(self: Path, **options: bool) -> os.stat_result:
        if self == hidden:
            raise FileNotFoundError(2, "No such file or directory")
        return real(self, **options)

    monkeypatch.setattr(Path, "stat", look)
