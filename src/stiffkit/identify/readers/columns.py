"""Numbers in fixed columns: whole blocks of text to arrays, without a loop over lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Bytes = NDArray[np.uint8]

CHUNK = 16384
"""Rows worked on at once, so that the digits stay in the processor's cache."""
WIDTH = 12
"""Columns of a number written as ``-1.23456E-01``."""
DIGITS = (1, 3, 4, 5, 6, 7)
POINT, EXPONENT, EXPONENT_SIGN, EXPONENT_DIGITS = 2, 8, 9, (10, 11)
DECIMALS = 5
EXACT = 22
"""Largest power of ten that a float holds exactly: one product or quotient rounds but once."""
POWERS = 10.0 ** np.arange(EXACT + 1)


class NotANumberError(ValueError):
    """Text in place of a number: the ``row`` it is in, counted from zero, and the ``text``."""

    def __init__(self, row: int, text: str) -> None:
        """Keep row and text."""
        super().__init__(f"row {row}: '{text}' is not a number")
        self.row = row
        self.text = text


def integers(text: Bytes) -> Integers:
    """Return whole numbers (n,) from the columns (n, w) of one field."""
    numbers = np.empty(len(text), dtype=np.int64)
    for start in range(0, len(text), CHUNK):
        fields = text[start : start + CHUNK]
        values, usual = _whole(fields)
        if not usual.all():
            try:
                values[~usual] = _converted(fields[~usual], np.int64)
            except NotANumberError as error:
                place = int(np.flatnonzero(~usual)[error.row])
                raise NotANumberError(start + place, error.text) from None
        numbers[start : start + CHUNK] = values
    return numbers


def floats(text: Bytes) -> Array:
    """Return numbers (n, k) from the columns (n, 12 k) of k fields, correctly rounded."""
    numbers = np.empty((len(text), text.shape[1] // WIDTH))
    for start in range(0, len(text), CHUNK):
        fields = np.ascontiguousarray(text[start : start + CHUNK]).reshape(-1, WIDTH)
        values, usual = _scientific(fields)
        if not usual.all():
            try:
                values[~usual] = _converted(fields[~usual], np.float64)
            except NotANumberError as error:
                place = int(np.flatnonzero(~usual)[error.row])
                raise NotANumberError(start + place // numbers.shape[1], error.text) from None
        numbers[start : start + CHUNK] = values.reshape(-1, numbers.shape[1])
    return numbers


def _whole(fields: Bytes) -> tuple[Integers, NDArray[np.bool_]]:
    """Return the values of fields (m, w) of spaces and then digits, and which are so."""
    columns = np.ascontiguousarray(fields.T)
    blank = columns == ord(" ")
    digits = np.where(blank, np.uint8(0), columns - np.uint8(ord("0")))
    usual = (digits <= 9).all(axis=0) & ~blank[-1] & ~(blank[1:] & ~blank[:-1]).any(axis=0)
    values = np.zeros(len(fields), dtype=np.int64)
    for column in digits:
        values = 10 * values + column
    return values, usual


def _scientific(fields: Bytes) -> tuple[Array, NDArray[np.bool_]]:
    """Return the values of fields (m, 12) written as ``-1.23456E-01``, and which are so."""
    columns = np.ascontiguousarray(fields.T)
    # What is no digit wraps round to a number above nine.
    digits = columns - np.uint8(ord("0"))
    usual = (digits[[*DIGITS, *EXPONENT_DIGITS]] <= 9).all(axis=0)
    usual &= (columns[POINT] == ord(".")) & (columns[EXPONENT] == ord("E"))
    negative, small = columns[0] == ord("-"), columns[EXPONENT_SIGN] == ord("-")
    usual &= negative | (columns[0] == ord(" "))
    usual &= small | (columns[EXPONENT_SIGN] == ord("+"))

    mantissa = np.zeros(len(fields), dtype=np.int32)
    for place in DIGITS:
        mantissa = 10 * mantissa + digits[place]
    tens, ones = digits[list(EXPONENT_DIGITS)].astype(np.int32)
    exponent = np.where(small, -1, 1) * (10 * tens + ones) - DECIMALS
    usual &= np.abs(exponent) <= EXACT
    power = POWERS[np.minimum(np.abs(exponent), EXACT)]
    size = np.where(exponent < 0, mantissa / power, mantissa * power)
    return np.where(negative, -size, size), usual


def _converted(fields: Bytes, dtype: type) -> NDArray[np.int64] | NDArray[np.float64]:
    """Return the numbers (n,) in fields (n, w) in any notation, by NumPy's own conversion."""
    words = np.ascontiguousarray(fields).view(f"S{fields.shape[1]}").ravel()
    try:
        return words.astype(dtype)
    except ValueError:
        for row, word in enumerate(words.tolist()):
            try:
                dtype(word)
            except ValueError:
                raise NotANumberError(row, word.decode("ascii", "replace").strip()) from None
        raise
