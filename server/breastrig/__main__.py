"""`python -m breastrig`: the command line where installed programs are not on the path."""

from breastrig.cli.entry import entry

if __name__ == "__main__":
    entry()
