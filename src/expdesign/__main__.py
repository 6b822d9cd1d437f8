"""`python -m expdesign COMMAND ...`, where the command `expdesign` is not on the path."""

from expdesign.app.commands.main import main

if __name__ == "__main__":  # processes that a sweep starts import this module too
    main()
