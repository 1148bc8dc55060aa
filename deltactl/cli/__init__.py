"""The command line: heavy imports happen inside commands.

In: words typed. Out: what people or programs read. `main` gathers the commands, `output` says how
they talk; `robot` moves and watches the machine, `recordings` diagnoses and corrects. Here are what
shows the robot in a browser, and the commands for networks.
"""
