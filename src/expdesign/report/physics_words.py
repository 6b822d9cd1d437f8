"""Identifiers of physics in words, as the effects themselves say what the base model leaves out."""

from functools import lru_cache

from expdesign.chain.models.effect_entry import effect_classes


@lru_cache(maxsize=1)
def _left_out() -> dict[str, str]:
    """What the base model leaves out, by the identifier of each physics; the first of several kinds."""
    found: dict[str, str] = {}
    for kind in effect_classes():
        found.setdefault(kind.physics, kind.declared.left_out)
    return found


def physics_words(identifier: str) -> str:
    """`payload_com_offset` as `error of the payload's centre of mass`; what is no effect with blanks."""
    return _left_out().get(identifier) or identifier.replace("_", " ")


def effect_words(key: str) -> str:
    """`leg_backlash / leg 4 / long` as `play of a leg (leg 4, long)`."""
    physics, *place = key.split(" / ")
    return f"{physics_words(physics)} ({', '.join(place)})" if place else physics_words(physics)
