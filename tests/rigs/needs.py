"""What a test says to install where a package is missing."""

LGPIO = "needs lgpio: 'make .venv/.test' brings it up to Python 3.12, else Debian's python3-lgpio"
LOGS = "needs the extra 'diagnosis' (MCAP of ROS 2, bags, Parquet): make extras WITH=diagnosis"
