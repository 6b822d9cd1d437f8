"""The form of an effect that depends on how far a sliding joint is extended."""

from enum import StrEnum


class Extension(StrEnum):
    """Its one variant, unlike the forms that do not depend on the extension."""

    WITH_EXTENSION = "with extension"
