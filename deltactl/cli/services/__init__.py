"""Commands that keep running: systemd units, the web page, Foxglove, the check of every run.

In: a robot's socket and folders. Out: servers, and files for other programs.
"""
