"""What Alembic runs around its commands; the connection, inside its transaction, comes from `database`."""

from alembic import context

from breastrig.storage.schema import metadata

context.configure(connection=context.config.attributes["connection"], target_metadata=metadata)
with context.begin_transaction():
    context.run_migrations()
