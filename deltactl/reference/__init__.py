"""Reference pages and JSON Schemas, made from the models and tables that the program itself uses.

In: pydantic models, the effect tables, the recording's channels and the socket's requests. Out:
`docs/reference/*.md` and `deltactl/schemas/*.json`, written by `make reference`; a test fails when
they are stale.
"""
