"""The command line: one small file a group of commands; heavy imports happen inside commands."""
