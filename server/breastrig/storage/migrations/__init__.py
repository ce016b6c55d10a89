"""Alembic's revisions of the tables, one file each in `versions`, run at the start of a server."""
