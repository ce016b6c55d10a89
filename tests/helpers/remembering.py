"""A process that imports this remembers what it computes, as tasks of services do; see remembered.py."""

from helpers.remembered import install

install()
