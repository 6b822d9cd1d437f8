"""`expdesign verify`: attained against predicted after compensation, with a test and a certificate."""

from expdesign.app.commands.call import Call
from expdesign.assurance.acceptance.certificate import About, read_about


def command(call: Call, operator: str = "", instrument: str = "", environment: str = "", date: str = "") -> None:
    """Verify, with texts of the certificate that stand in options.

    Args:
        call: the command.
        operator: who measured.
        instrument: what was measured with.
        environment: e.g. the temperature.
        date: when it was measured.
    """
    given = {"operator": operator, "instrument": instrument, "environment": environment, "date": date}
    about = read_about(call.given["about"]) if "about" in call.given else About()
    call.carried_out(about=about.model_copy(update={key: value for key, value in given.items() if value}))
