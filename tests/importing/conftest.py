"""The real command line in an empty folder."""

from tests.cli.conftest import deltactl as deltactl
