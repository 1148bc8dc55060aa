"""What an assistant that speaks the Model Context Protocol may ask: `deltactl mcp`.

In come calls of tools over standard input; out go answers of a bounded length whose numbers are
those of the JSON of the same diagnosis, that JSON as a resource, and refusals in parts. Nothing is
written and nothing moves. The work is done by the Python interface, in processes of its own.
"""
