"""Validation of YAML content against pydantic models, with messages that name file, line, key and remedy."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar, get_args

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.yaml_reader import KeyPath, YamlDocument, document_from_mapping, dotted

LARGEST = 1e20
"""No quantity in SI units is larger, nor a positive one smaller than its inverse; squares are far from overflow."""
LARGEST_COUNT = 1_000_000
"""No count (of measurements, generations, points of an axis) is larger."""


def _sensible(value: float) -> float:
    if abs(value) > LARGEST:
        raise invalid(f"{shortened(value)} is beyond any quantity in SI units", remedy="Check the exponent.")
    return value


def _not_tiny(value: float) -> float:
    if 0.0 < value < 1.0 / LARGEST:
        raise invalid(f"{value:g} is below any quantity in SI units", remedy="Check the exponent.")
    return value


Number = Annotated[float, Field(strict=True, allow_inf_nan=False), AfterValidator(_sensible)]
Positive = Annotated[Number, Field(gt=0.0), AfterValidator(_not_tiny)]
NonNegative = Annotated[Number, Field(ge=0.0), AfterValidator(_not_tiny)]
Count = Annotated[int, Field(strict=True, ge=1, le=LARGEST_COUNT)]


class Section(BaseModel):
    """A mapping in a YAML file: its keys are fixed, and an unknown one is answered with the nearest known one.

    In Python it is an object with the keys as arguments, checked as in a file: numbers, texts with units, arrays,
    paths and other sections are taken. It knows where it stands (`where`).
    """

    __slots__ = ("_document",)
    model_config = ConfigDict(extra="forbid", frozen=True)

    def __init__(self, /, **content: Any) -> None:
        """Check the content of the mapping.

        Raises:
            InputError: a key is missing, unknown or wrong.
        """
        document = document_from_mapping(content, self.__repr_name__())
        try:
            self.__pydantic_validator__.validate_python(document.content, self_instance=self)
        except ValidationError as error:
            raise _as_input_error(error, document) from None
        self._stand_in(document)

    # Where a mapping is read, pydantic checks its parts itself: only what is made in Python comes through here.
    __init__.__pydantic_base_init__ = True  # type: ignore[attr-defined]

    def __repr_name__(self) -> str:
        return type(self).__name__.removesuffix("Section")

    def __repr_args__(self) -> Iterable[tuple[str | None, Any]]:
        return [(name, value) for name, value in super().__repr_args__() if name in self.model_fields_set]

    @property
    def document(self) -> YamlDocument:
        """The part of a file that it was read from; of a section that another process sent, what it would be there."""
        found: YamlDocument | None = getattr(self, "_document", None)
        return found or YamlDocument(self.__repr_name__(), Path(), self.as_mapping())

    def where(self, *path: str | int) -> YamlDocument:
        """What stands at one of its keys, or below one; itself without any."""
        return self.document.where(*path)

    def with_values(self, **values: Any) -> Self:
        """The same section with other values at some keys, which are not checked again."""
        changed = self.model_copy(update=values)
        object.__setattr__(changed, "_document", self.document)
        return changed

    def _stand_in(self, document: YamlDocument) -> None:
        """Remember the document of this section, and those of the sections in it."""
        object.__setattr__(self, "_document", document)
        for name, field in type(self).model_fields.items():
            if next(_sections(field.annotation), None):  # a covariance may have 400,000 numbers, and no section
                _stand(getattr(self, name), document.where(field.alias or name))

    def as_mapping(self) -> dict[str, Any]:
        """The content as it stands in YAML, SI units."""
        return self.model_dump(mode="json", exclude_none=True)

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            raise PydanticCustomError("not_a_mapping", "a mapping (`key: value`) is needed here")
        known = [f.alias or name for name, f in cls.model_fields.items()]
        for key in data:
            if key not in known:
                raise unknown_key(str(key), known)
        return data


def _stand(value: Any, document: YamlDocument) -> None:
    """Have the sections that a value is or holds remember their documents."""
    if isinstance(value, Section):
        value._stand_in(document)
    elif isinstance(value, list | tuple | dict):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            _stand(each, document.where(key))


def unknown_key(key: str, known: list[str]) -> PydanticCustomError:
    """The error for `key`, which names the nearest of `known` (or all of them, where none is near)."""
    halved = key.isdigit()  # of `{std: 0,01}` YAML makes `std: 0` and the key `01`
    remedy = "Is there a decimal comma before it? Write a point." if halved else nearest(key, known)
    return PydanticCustomError("unknown_key", "unknown key", {"key": key, "remedy": remedy})


S = TypeVar("S", bound=Section)


def validate(model: type[S], document: YamlDocument) -> S:
    """`document` as `model`.

    Raises:
        InputError: the first thing that is wrong, with the number of further ones.
    """
    try:
        found = model.model_validate(document.content)
    except ValidationError as error:
        raise _with_place(_as_input_error(error, document), model) from None
    found._stand_in(document)
    return found


def _with_place(error: InputError, model: type[BaseModel]) -> InputError:
    """The error with the sections of the file in which an unknown key is known."""
    key = (error.where or "").rpartition(".")[2]
    places = dict.fromkeys(_places(model, key)) if error.what == "unknown key" else {}
    if not places:
        return error
    sections = " or ".join(f"`{place}`" if place else "the top level" for place in places)
    return InputError(error.what, where=error.where, remedy=f"It belongs in {sections}.")


def _places(model: type[BaseModel], key: str, above: str = "") -> Iterator[str]:
    """Dotted names of the sections of a file that have the key `key`."""
    for name, field in model.model_fields.items():
        if (field.alias or name) == key:
            yield above
        for section in _sections(field.annotation):
            yield from _places(section, key, f"{above}.{field.alias or name}".lstrip("."))


def _sections(annotation: Any) -> Iterator[type[BaseModel]]:
    """Sections that a type is made of, through unions, lists and annotations."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _sections(part)


def invalid(message: str, key: str | None = None, remedy: str = "") -> PydanticCustomError:
    """An error raised inside a model's validator; `key` is the key below the validated mapping."""
    context: dict[str, Any] = {"remedy": remedy}
    if key is not None:
        context["key"] = key
    return PydanticCustomError("invalid", message.replace("{", "{{").replace("}", "}}"), context)


def shortened(value: Any) -> str:
    """`value` as a message shows it."""
    text = f"{value:g}" if isinstance(value, float) else repr(value)
    return text if len(text) <= 40 else f"{text[:40]}..."


_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")
_NUMBER = "a number is needed here", "Write a plain number (SI units), or a text with its unit such as '0.5 mm'."
_LIST = "a list is needed here", "Write a list such as `[0.0, 1.0]`."
_REMEDIES = {
    "missing": ("the key is missing", "Add it."),
    "float_type": _NUMBER,
    "float_parsing": _NUMBER,
    "int_type": ("a whole number is needed here", "Write a whole number without quotes."),
    "finite_number": ("a finite number is needed here", "NaN and infinity are not allowed."),
    "string_type": ("a text is needed here", "Write a text."),
    "bool_type": ("`true` or `false` is needed here", "Write `true` or `false`."),
    "dict_type": ("a mapping (`key: value`) is needed here", "Write `key: value`."),
    "list_type": _LIST,
    "tuple_type": _LIST,
}


def _as_input_error(error: ValidationError, document: YamlDocument) -> InputError:
    details = error.errors(include_url=False)
    paths = [_existing(detail["loc"], document.content, detail["type"] == "missing") for detail in details]
    # Of the members of a union, the one that got further into the file is the one that was meant.
    deeper = (i for i, path in enumerate(paths) if len(path) > len(paths[0]) and path[: len(paths[0])] == paths[0])
    index = next(deeper, 0) if details[0]["type"] in _REMEDIES else 0
    first, path = details[index], paths[index]
    kind, context = first["type"], first.get("ctx") or {}
    if "key" in context:
        path = (*path, *str(context["key"]).split("."))
    what, remedy = _problem(first["msg"], kind, context, first.get("input"))
    if len(details) > 1:
        others = sorted({dotted(other) for other in paths if other != path[: len(other)]})
        remedy += f" (Also wrong: {', '.join(others[:3])}.)" if others else ""
    return InputError(what[:1].lower() + what[1:], where=str(document.where(*path)), remedy=remedy.strip())


_SHORT = 1000
"""Whole numbers before a decimal comma are smaller."""


def _problem(message: str, kind: str, context: dict[str, Any], value: Any) -> tuple[str, str]:
    """What is wrong and what to do, from one of pydantic's errors."""
    given = f", not {shortened(value)}" if kind != "missing" and isinstance(value, str | int | float | None) else ""
    if kind in _REMEDIES:
        what, remedy = _REMEDIES[kind]
        comma = isinstance(value, str) and _DECIMAL_COMMA.fullmatch(value.strip())
        return what + given, "Write a decimal point instead of the comma." if comma else remedy
    if kind in {"too_short", "too_long"}:
        limit = context.get("min_length") if kind == "too_short" else context.get("max_length")
        bound, count = f"at {'least' if kind == 'too_short' else 'most'} {limit}", context.get("actual_length")
        return f"{bound} entries are needed here, not {count}", decimal_commas(
            count, limit, value
        ) or "Correct the list."
    if kind in {"greater_than", "greater_than_equal"}:
        bound = f"greater than {context['gt']:g}" if kind == "greater_than" else f"at least {context['ge']:g}"
        return f"the number must be {bound}{given}", "Correct it (SI units)."
    if kind == "less_than_equal":
        return f"the number must be at most {context['le']:g}{given}", "Correct it."
    if kind == "literal_error":
        return f"{shortened(value)} is not known here", f"Write {context['expected']}."
    return message.removeprefix("Value error, "), str(context.get("remedy") or "Correct it.")


def decimal_commas(count: int | None, limit: int | None, entries: Any = None) -> str:
    """The remedy for a list with too many entries: YAML takes a decimal comma for the end of an entry.

    That is, twice as many as allowed, or entries of which at least so many as are too many are whole and follow a short
    whole one (`0,298`).
    """
    if count is None or limit is None or not limit < count <= 2 * limit:
        return ""
    values = entries if isinstance(entries, list) else []
    whole = [isinstance(value, int) and not isinstance(value, bool) for value in values]
    pairs = [
        f"{first},{second}"
        for first, second, both in zip(values, values[1:], np.logical_and(whole[:-1], whole[1:]), strict=False)
        if both and abs(first) < _SHORT and second > 0
    ]
    if count == 2 * limit:
        return "Are these decimal commas? Write points: `[5.0e6, ...]`, not `[5,0e6, ...]`."
    if len(pairs) < count - limit:
        return ""
    return f"Is `{pairs[-1]}` a decimal comma? Write a point: `{pairs[-1].replace(',', '.')}`."


def _existing(loc: tuple[int | str, ...], content: Any, keep_last: bool) -> KeyPath:
    """The part of pydantic's location that is a key path of the file (it also names the members of unions)."""
    path: list[int | str] = []
    for index, key in enumerate(loc):
        is_key = isinstance(content, dict) and key in content
        is_index = isinstance(content, list) and isinstance(key, int) and key < len(content)
        if is_key or is_index:
            path.append(key)
            content = content[key]
        elif keep_last and index == len(loc) - 1:
            path.append(key)
    return tuple(path)
