"""Commands that concern jobs: run, follow, check, report, export."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from deltactl.cli.file_arguments import (
    ForceOption,
    refuse_existing,
    refuse_other_page,
    refuse_recorded,
)
from deltactl.cli.help_screens import MORE
from deltactl.cli.output import waiting

JobArgument = Annotated[Path, typer.Argument(help="Job file; sought here, then in config/.")]
JsonOption = Annotated[bool, typer.Option("--json", help="One JSON document instead of tables.")]
RobotOption = Annotated[
    str | None, typer.Option(help="Robot file instead of the job's, as one that was corrected.")
]
AcceptOption = Annotated[
    float,
    typer.Option(
        help="You have looked at the arms, and accept that no sensor would show one that is off"
        " by so many degrees. A simulated robot needs no such word.",
        min=0.0,
        max=360.0,
    ),
]
SocketOption = Annotated[
    Path | None, typer.Option(help="Socket of the daemon.", rich_help_panel=MORE)
]
ABOUT = """Watch, hold, end or verify a job.

```
deltactl job follow
deltactl job pause
deltactl job verify heart.yaml
```
"""


def run(
    job: JobArgument,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="On a simulated robot in this process, no daemon.")
    ] = False,
    realtime: Annotated[
        bool,
        typer.Option("--realtime", help="Simulated robot in real time, not as fast as possible."),
    ] = False,
    record: Annotated[Path | None, typer.Option(help="Where to record (.mcap).")] = None,
    report: Annotated[Path | None, typer.Option(help="Write an HTML report here.")] = None,
    robot: RobotOption = None,
    accept_unseen: AcceptOption = 0.0,
    seed: Annotated[
        int | None,
        typer.Option(
            help="Other noise of the simulated sensors; without it each run has the same.", min=0
        ),
    ] = None,
    detach: Annotated[
        bool,
        typer.Option(
            "--detach",
            help="Let the daemon go on alone once the job is checked; 'deltactl job follow' watches"
            " it. Without it the job ends with this command.",
        ),
    ] = False,
    json_out: JsonOption = False,
    socket: SocketOption = None,
    force: ForceOption = False,
) -> None:
    """Run a job: on the robot through its daemon, or on the simulated robot.

    Shows progress, then how well the path was followed, and where the recording is. The robot of a
    daemon is homed before ('deltactl home'); the simulated one homes here. How fast and how often
    is in the job: in 'timing' speed_mps or duration_s, and 'repeats'.

    ```
    deltactl run heart.yaml
    deltactl run circle.yaml --realtime --report circle.html
    deltactl run heart.yaml --robot corrected.yaml
    deltactl run survey.yaml --simulate --record survey.mcap --json
    deltactl run mine.yaml --simulate --seed 2
    deltactl run survey.yaml --detach
    ```
    """
    with waiting("loading", json_out):
        from deltactl.cli.robot.run import Asked, run_job

    refuse_existing(force, report)
    refuse_other_page(report)
    refuse_recorded(record)
    asked = Asked(
        robot=robot,
        simulate=simulate or realtime,
        realtime=realtime,
        record=record,
        report=report,
        json_out=json_out,
        socket=socket,
        accept_unseen_deg=accept_unseen,
        seed=seed,
        detach=detach,
    )
    run_job(job, asked)


def follow(
    job_id: Annotated[
        int | None, typer.Argument(help="Number of the job; without it the one that runs.", min=1)
    ] = None,
    json_out: JsonOption = False,
    socket: SocketOption = None,
) -> None:
    """Watch a job of the daemon to its end, whoever started it; Ctrl-C only ends the watching.

    ```
    deltactl job follow
    deltactl job follow 7 --json
    ```
    """
    from deltactl.cli.robot.remote import follow_job

    follow_job(job_id, json_out, socket)


def check(job: JobArgument, robot: RobotOption = None, json_out: JsonOption = False) -> None:
    """Dry run: limits, duration, peak step rate, what is compensated; nothing moves.

    ```
    deltactl check heart.yaml
    deltactl check heart.yaml --robot corrected.yaml
    ```
    """
    from deltactl.cli.robot.check import check_job

    check_job(job, robot, json_out)


def verify(
    job: JobArgument,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="On a simulated robot in this process, no daemon.")
    ] = False,
    json_out: JsonOption = False,
    socket: SocketOption = None,
) -> None:
    """Were steps lost? Homes, runs the job, goes home again, and compares the sensors.

    ```
    deltactl job verify heart.yaml
    ```
    """
    from deltactl.cli.robot.run import verify_job

    verify_job(job, simulate, json_out, socket)


def report(
    recording: Annotated[Path, typer.Argument(help="A recorded run (.mcap).")],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="HTML file to write.")] = None,
    json_out: JsonOption = False,
    force: ForceOption = False,
) -> None:
    """Tracking errors of a recorded run, and one HTML file with the curves.

    ```
    deltactl report recordings/heart.mcap -o heart.html
    ```
    """
    from deltactl.cli.robot.show import show_recording

    page = out or recording.with_suffix(".html")
    refuse_existing(force, page)
    refuse_other_page(page)
    show_recording(recording, page, json_out)


def record(
    out: Annotated[Path, typer.Argument(help="File to write (.mcap).")],
    seconds: Annotated[float, typer.Option(help="Duration, s.")] = 10.0,
    robot: Annotated[
        str | None,
        typer.Option(help="Robot file with the sensors; without it, the one in this folder."),
    ] = None,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Simulated sensors in real time.")
    ] = False,
) -> None:
    """Record the sensors alone, while somebody moves the platform. Runs record themselves.

    ```
    deltactl status record by-hand.mcap --seconds 30
    ```
    """
    from deltactl.cli.robot.sensors import record_sensors

    record_sensors(out, seconds, robot, realtime)


def export(
    source: Annotated[
        Path, typer.Argument(help="A recorded run (.mcap); for .urdf and .xml a robot file.")
    ],
    out: Annotated[
        Path,
        typer.Argument(
            help="File to write: a table (.csv, .csv.gz, .parquet, .mat), ROS 2 messages (.mcap),"
            " or the robot as .urdf or MJCF (.xml)."
        ),
    ],
    truth: Annotated[
        bool, typer.Option("--truth", help="Also the simulated robot's true position.")
    ] = False,
    force: ForceOption = False,
) -> None:
    """Turn a recorded run into a flat table, or a run or a robot into files of other programs.

    A table has one row every 20 ms. An .mcap has JointState, TF and the robot's URDF, for
    Foxglove and rviz. MuJoCo reads the .xml, in which the loops of the delta are closed. The model
    of a chain of joints gets the friction and the load that were found.

    ```
    deltactl export recordings/heart.mcap heart.csv
    deltactl export recordings/heart.mcap heart-ros2.mcap
    deltactl export zhao-2023.yaml zhao.urdf
    deltactl export zhao-2023.yaml zhao.xml
    deltactl export arm-corrected.yaml arm-corrected.urdf
    ```
    """
    from deltactl.cli.robot.show import ROBOT_FORMATS, export_recording, export_robot, export_to_ros
    from deltactl.foundation.errors import ConfigError

    refuse_existing(force, out)
    ending = out.suffix.lower()
    if truth and ending in (*ROBOT_FORMATS, ".mcap"):
        raise ConfigError(f"--truth is for tables, and {out} is none; leave it out")
    if ending in ROBOT_FORMATS:
        export_robot(source, out)
    elif ending == ".mcap":
        if out.resolve() == source.resolve():
            raise ConfigError(f"{out}: is the recording itself; name another file")
        export_to_ros(source, out)
    else:
        export_recording(source, out, truth)
