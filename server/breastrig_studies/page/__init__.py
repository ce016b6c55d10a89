"""How the studies are shown."""
