"""`python -m colonysim` is the same as `colonysim`."""

from colonysim.cli import main

if __name__ == "__main__":
    main()
