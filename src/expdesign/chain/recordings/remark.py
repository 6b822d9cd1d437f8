"""What a computation has to say of recordings, as data; `report/remark_texts.py` puts it into words."""


class Remark:
    """One thing that a user must know: a frozen dataclass with the figures that a sentence needs."""
