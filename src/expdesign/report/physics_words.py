"""Identifiers of physics in words, as the effects themselves say what the base model leaves out."""

from functools import lru_cache

from expdesign.chain.models.effect_entry import effect_classes


@lru_cache(maxsize=1)
def _left_out() -> dict[str, list[tuple[str, str]]]:
    """What the base model leaves out, by the identifier of each physics: of every kind its folder and the words."""
    found: dict[str, list[tuple[str, str]]] = {}
    for kind in effect_classes():
        folder = kind.__module__.rsplit(".", 2)[-2]
        found.setdefault(kind.physics, []).append((folder, kind.declared.left_out))
    return found


def physics_words(identifier: str, component: str = "") -> str:
    """`payload_com_offset` as `error of the payload's centre of mass`; what is no effect with blanks.

    Of several kinds the one of the component: an encoder's error is another at `leg 3` than at `joint 3`.
    """
    kinds = _left_out().get(identifier, [])
    part = component.removeprefix("all ").split(" ")[0].rstrip("s")
    own = [words for folder, words in kinds if part and folder.rstrip("s") == part]
    return next((words for words in (*own, *(words for _, words in kinds)) if words), identifier.replace("_", " "))


def effect_words(key: str) -> str:
    """`leg_backlash / leg 4 / long` as `play of a leg (leg 4, long)`."""
    physics, *place = key.split(" / ")
    return f"{physics_words(physics, place[0])} ({', '.join(place)})" if place else physics_words(physics)
