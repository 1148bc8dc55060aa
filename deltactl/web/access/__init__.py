"""Who may use the page, and what a browser may send: users, guard, login, pages.

In come a browser's request, its cookie and the files that somebody uploads; out go a session with
its role, or a refusal. docs/security.md says what is promised.
"""
