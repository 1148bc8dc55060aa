"""Figures that the documents quote, each printed by a command of its own.

`python benchmarks/ROOM/NAME.py --help` says what one prints. `proofs`: is the diagnosis right;
`costs`: what things take; `endurance`: does the machine survive; `mutation`: do tests notice
mistakes; `structure.py`: the shape of the source; `size.py`: how much of it there is.
"""
