"""Numbers with their nouns in messages."""


def counted(number: int, noun: str, several: str = "") -> str:
    """`1 row`, `2 rows`; `several` is the plural where it is irregular (`axes`)."""
    return f"{number} {noun}" if number == 1 else f"{number} {several or noun + 's'}"
