"""Every error that a user can cause or must know about, in one hierarchy.

Each says where it happened, what is wrong and what to do about it, so that a command can print one message and
exit with status 2. Anything that is not an ``ExpdesignError`` is a defect of the program.

Messages speak of arguments (argument `prior`, argument `frames=unknown`), in whose place a command says the option.
"""


class ExpdesignError(Exception):
    """Base of all errors that are reported to the user as one message.

    Args:
        what: what is wrong.
        where: the file, and the key or the row and column, that it concerns; empty where there is none.
        remedy: what the user can do about it.
    """

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        self.what = what
        self.where = where
        self.remedy = remedy
        super().__init__(self.message)

    @property
    def message(self) -> str:
        """The parts in one line: where, what and what to do."""
        head = f"{self.where}: {self.what}" if self.where else self.what
        stop = "" if head.endswith(("?", "!", ".")) else "."
        return f"{head}{stop} {self.remedy}" if self.remedy else head


class InputError(ExpdesignError):
    """A file or an argument does not say what it must say."""


class ArgumentError(InputError):
    """An argument of a function cannot be what was given; on the command line it is an option.

    Args:
        what: what is wrong.
        argument: its name.
        remedy: what the caller can do about it.
    """

    def __init__(self, what: str, *, argument: str, remedy: str = "") -> None:
        self.argument = argument
        super().__init__(what, where=f"argument `{argument}`", remedy=remedy)


class SingularConfigurationError(ExpdesignError):
    """The mechanism is singular, or nearly so, at a pose that a result would have to rely on."""


class NotIdentifiableError(ExpdesignError):
    """The measurements do not determine the parameters that a result needs."""


class InfeasibleError(ExpdesignError):
    """No design, or no command, satisfies every limit."""


class ConvergenceError(ExpdesignError):
    """An iteration ended without reaching its tolerance."""
