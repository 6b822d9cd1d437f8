"""Help of a command, its options in groups: what belongs together stands together, under the same title everywhere."""

from typing import Any

from typer.core import TyperCommand

GROUPS: dict[str, tuple[str, ...]] = {
    "Measurements": ("shared_reference", "frames", "frame", "unit", "std", "base_frame", "interpolate", "other_robot"),
    "Arms": ("loss", "further", "hold", "accept"),
    "Computing": ("seconds", "samples", "random", "generations", "seed", "nodes", "workers", "cluster"),
    "Results": ("out", "units", "record", "json", "force", "strict"),
}
"""Options by the titles under which they stand; all others are of what the command is about."""
_TITLES = {name: title for title, names in GROUPS.items() for name in names}


class GroupedCommand(TyperCommand):
    """A command whose help has its options in groups."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        sections: dict[str, list[tuple[str, str]]] = {title: [] for title in ("Arguments", "Options", *GROUPS)}
        for parameter in self.get_params(ctx):
            shown = parameter.get_help_record(ctx)
            if shown is not None:
                title = _TITLES.get(str(parameter.name), "Options")
                sections["Arguments" if parameter.param_type_name == "argument" else title].append(shown)
        for title, rows in sections.items():
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)
