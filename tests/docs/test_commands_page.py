"""docs/commands.md has what the commands say of themselves."""

from tests.docs.test_tutorial import loaded


def test_the_page_is_what_the_script_makes() -> None:
    """Make it again with `python docs/commands.py`."""
    script = loaded("commands")
    assert script.PAGE.read_text(encoding="utf-8") == script.page()
