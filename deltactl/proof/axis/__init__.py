"""Single axes and range sensors of the proof, simulated without any of the diagnosis' code.

`motions` moves them, `drives` holds the physics, `commanded`, `forced` and `sensing`
are the three machines and how they are read, `catalogue` says what may be hidden in them,
`observer` what an ideal observer could tell, and `cases` draws one machine for each seed.
"""
