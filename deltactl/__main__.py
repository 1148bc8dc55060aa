"""`python -m deltactl`, where the command is not on the path."""

from deltactl.cli.main import main

if __name__ == "__main__":  # a worker that is spawned imports it too
    main()
