"""`expdesign sweep`: many runs with other values, resumable, on one machine or a cluster."""

from expdesign.app.commands.call import Call, note


def command(call: Call) -> None:
    """Do the runs; who interrupts them is told how they go on."""
    try:
        call.carried_out()
    except KeyboardInterrupt:
        note("Finished runs are kept; the same command goes on from there.")
        raise
