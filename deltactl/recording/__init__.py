"""What a run leaves behind, in four rooms.

`format` says what a recording holds; `writing` puts a run on the disk, `reading` gets it back as
arrays, and `tables` are flat recordings, one row a sample, in any file that holds a table.
`format` knows no other room, `writing` and `reading` know `format`, `tables` knows `reading`.
"""
