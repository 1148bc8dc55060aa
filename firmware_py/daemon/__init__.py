"""The daemon: owns the controller, and lets clients speak to it over a Unix socket."""
