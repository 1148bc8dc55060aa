"""What the pages are built on: the link to the daemon, folders, robot files, and slow work.

In come the daemon's status, the recordings and what a browser sent; out go what a page shows, and
the answers of processes of their own. Nothing here knows what a page looks like.
"""
