"""What `import deltactl` offers to a notebook or a script; each file is one class of it.

The package lists the names and imports a file of this folder when one of its names is first used.
"""
