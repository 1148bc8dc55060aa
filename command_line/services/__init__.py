"""Commands for what stays running: systemd units, the page, Foxglove, the look at every run.

In: a robot's socket and folders. Out: servers, and files for other programs.
"""
