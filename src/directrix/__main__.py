"""``python -m directrix`` is the command line."""

from directrix.cli import main

if __name__ == "__main__":
    main()
