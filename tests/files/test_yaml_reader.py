"""YAML as people write it: numbers of YAML 1.2, and one message where something is wrong."""

from pathlib import Path

import pytest

from expdesign.errors import InputError
from expdesign.io.yaml_reader import parse_yaml, read_yaml


def content(text: str) -> object:
    return parse_yaml(text, "x.yaml", Path()).content


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e8", 1e8),
        ("2.5e7", 2.5e7),
        ("1E-6", 1e-6),
        ("-1.5e+3", -1500.0),
        (".5", 0.5),
        ("5.", 5.0),
        ("-0.0", -0.0),
        ("+3", 3),
        ("010", 10),
        ("26.5", 26.5),
    ],
)
def test_numbers(text: str, value: float) -> None:
    found = content(f"a: {text}")
    assert isinstance(found, dict)
    assert found["a"] == value
    assert isinstance(found["a"], type(value))


@pytest.mark.parametrize("text", ["1:30", "2020-01-01", "1_000", "0x10", "1e", "e8", "1.2.3", "'1e8'"])
def test_what_is_not_a_number_is_text(text: str) -> None:
    assert content(f"a: {text}") == {"a": text.strip("'")}


def test_lines_and_keys() -> None:
    document = parse_yaml("a: 1\nb:\n  - c: 2\n  - c: 3\n    d: 4\n", "x.yaml", Path())
    assert str(document.where()) == "x.yaml"
    assert str(document.where("b", 1, "d")) == "x.yaml, line 5, b[1].d"
    assert str(document.where("b", 1, "missing")) == "x.yaml, line 4, b[1].missing"
    part = document.where("b", 1)
    assert part.content == {"c": 3, "d": 4}
    assert str(part.where("d")) == "x.yaml, line 5, b[1].d"


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("a: 1\nb: 2\na: 3\n", "line 3, a"),
        ("t:\n  - x: 1\n    x: 2\n", "line 3, t[0].x"),
        ("a: [1, 2\nb: 3\n", "line 2"),
        ("a: 1\n  b: 2\n", "line 2"),
        ("\tb: 1\n", "line 1"),
        ("a: b: c\n", "line 1"),
        ("a: &x [*x]\n", "line 1"),
        ("a: *nowhere\n", "line 1"),
        ("a: 1\n---\nb: 2\n", "line 2"),
        ("a: !!python/object:os.system 1\n", "line 1"),
        ("a: \x00\n", "x.yaml"),
        ("? [1, 2]\n: 3\n", "line 1"),
    ],
)
def test_broken_yaml_names_its_line(text: str, where: str) -> None:
    with pytest.raises(InputError) as error:
        content(text)
    assert error.value.where.startswith("x.yaml")
    assert where in error.value.where
    assert error.value.what
    assert error.value.remedy


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    binary = tmp_path / "b.yaml"
    binary.write_bytes(b"a: \xff\xfe")
    for path, what in ((tmp_path / "none.yaml", "no such file"), (tmp_path, "folder"), (binary, "UTF-8")):
        with pytest.raises(InputError, match=what) as error:
            read_yaml(path)
        assert str(path) in error.value.where
        assert error.value.remedy


def test_byte_order_mark_and_empty_file(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\n")
    assert read_yaml(path).content == {"a": 1}
    path.write_text("# nothing\n")
    assert read_yaml(path).content is None
