"""The command line: heavy imports happen inside commands.

In: words typed. Out: what people or programs read. `main` gathers the groups of commands, `output`
says how they talk; `robot` moves and watches the machine, `recordings` diagnoses and corrects,
`networks` trains and evaluates, `services` is what stays running.
"""
