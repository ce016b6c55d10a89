"""How the tables of each version become those of the next: Alembic's revisions, one file each in `versions`.

They are part of the package, because every server brings its own database up to date at its start.
"""
