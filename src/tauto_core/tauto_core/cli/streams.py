"""Standard output and error, be they closed, full, or of another encoding than UTF-8."""

from __future__ import annotations

import codecs
import io
import os
import sys
import unicodedata

_PLAIN = {'−': '-', '–': '-', '—': '-', '…': '...', '√': 'sqrt', '≤': '<=', '≥': '>=', '→': '->'}
_GREEK = 'GREEK SMALL LETTER '
_HANDLER = 'tauto_plain'


def prepare_streams() -> None:
    """Let any text be printed, on any terminal."""
    open_closed_streams()
    codecs.register_error(_HANDLER, _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_HANDLER)


def drop_output() -> None:
    """Discard output that stdout refused; otherwise the interpreter fails on it again at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def open_closed_streams() -> None:
    """Open the null device in the place of streams that were closed (`2>&-`, some daemons).

    Python has None for them, and the next file to be opened would get their number, with all that
    C libraries print.
    """
    for name, mode in (('stdin', 'r'), ('stdout', 'w'), ('stderr', 'w')):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding='utf-8'))  # noqa: SIM115


def _plain(error: UnicodeError) -> tuple[str | bytes, int]:
    """Return what stands for a character that an encoding lacks, and the place after it.

    A minus must stay one. Python has lone surrogates for bytes of a file's name that are no text;
    they are printed as they are, as other programs do.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    character, after = error.object[error.start], error.start + 1
    if '\udc80' <= character <= '\udcff':
        return bytes([ord(character) - 0xDC00]), after
    name = unicodedata.name(character, '')
    if name.startswith(_GREEK):
        return name.removeprefix(_GREEK).lower(), after
    return _PLAIN.get(character) or ascii(character)[1:-1], after
