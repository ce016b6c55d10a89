"""Streams in the age format, version 1, with one passphrase (age-encryption.org/v1): any `age` program opens them.

The header has the file's key, encrypted under scrypt of the passphrase; then chunks of 64 kB follow, each with
ChaCha20-Poly1305 under a counter that also says which is the last.  Primitives are those of `cryptography`.
"""

import base64
import hmac
import os
import re
from typing import IO

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import ChaCha20Poly1305
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDF
from cryptography.hazmat.primitives.kdf.scrypt import Scrypt

from breastrig.core.errors import BadInput

VERSION = b"age-encryption.org/v1"
CHUNK, TAG = 65_536, 16
WORK, MOST_WORK = 18, 20  # log2 of scrypt's N: a second and 256 MB; more would only cost who opens
HEADER = re.compile(rb"age-encryption\.org/v1\n-> scrypt ([\w+/]{22}) (\d\d?)\n([\w+/]{43})\n---")
NO_BACKUP = "The file is no backup of BreastRig: it is not encrypted by age with a passphrase."
WRONG = "The passphrase is not the one of this backup; try another."
DAMAGED = "The backup ends too early, or bytes of it are not those that were written; take another copy of it."


class SealedWriter:
    """Encrypts what is written; the file is whole only after `close`."""

    def __init__(self, file: IO[bytes], passphrase: str) -> None:
        self._file, self._left, self._number = file, bytearray(), 0
        key, salt, nonce, work = os.urandom(16), os.urandom(16), os.urandom(16), WORK
        wrapped = ChaCha20Poly1305(_scrypt(passphrase, salt, work)).encrypt(bytes(12), key, None)
        head = VERSION + b"\n-> scrypt " + _text(salt) + b" %d\n" % work + _text(wrapped) + b"\n---"
        file.write(head + b" " + _text(_mac(key, head)) + b"\n" + nonce)
        self._cipher = ChaCha20Poly1305(_derived(key, nonce, b"payload"))

    def write(self, content: bytes) -> int:
        self._left += content
        while len(self._left) > CHUNK:  # the last chunk is known at the end alone
            self._seal(bytes(self._left[:CHUNK]), False)
            del self._left[:CHUNK]
        return len(content)

    def close(self) -> None:
        self._seal(bytes(self._left), True)

    def _seal(self, content: bytes, last: bool) -> None:
        self._file.write(self._cipher.encrypt(_nonce(self._number, last), content, None))
        self._number += 1


class SealedReader:
    """Decrypts what `SealedWriter` or an age program has written.  Raises BadInput with one sentence."""

    def __init__(self, file: IO[bytes], passphrase: str) -> None:
        found = HEADER.match(head := file.read(200))
        if found is None or not 1 <= int(found[2]) <= MOST_WORK:
            raise BadInput(NO_BACKUP if not head.startswith(VERSION[:20]) or len(head) == 200 else DAMAGED)
        try:
            key = ChaCha20Poly1305(_scrypt(passphrase, _bytes(found[1]), int(found[2]))).decrypt(
                bytes(12), _bytes(found[3]), None
            )
        except InvalidTag:
            raise BadInput(WRONG) from None
        end = found.end() + 1 + 43 + 1
        if not hmac.compare_digest(_text(_mac(key, found[0])), head[found.end() + 1 : end - 1]):
            raise BadInput(DAMAGED)
        file.seek(end)
        self._file, self._number, self._left, self._ended = file, 0, b"", False
        self._cipher = ChaCha20Poly1305(_derived(key, file.read(16), b"payload"))
        self._next = file.read(CHUNK + TAG)

    def read(self, size: int) -> bytes:
        """At most so many bytes; fewer at the end alone."""
        parts = [self._left]
        there = len(self._left)
        while there < size and not self._ended:
            parts.append(self._open())
            there += len(parts[-1])
        whole = b"".join(parts)
        self._left = whole[size:]
        return whole[:size]

    def _open(self) -> bytes:
        sealed, self._next = self._next, self._file.read(CHUNK + TAG)
        self._ended = not self._next
        try:
            content = self._cipher.decrypt(_nonce(self._number, self._ended), sealed, None)
        except InvalidTag:
            raise BadInput(DAMAGED) from None
        self._number += 1
        return content


def _scrypt(passphrase: str, salt: bytes, work: int) -> bytes:
    return Scrypt(salt=VERSION + b"/scrypt" + salt, length=32, n=2**work, r=8, p=1).derive(passphrase.encode())


def _derived(key: bytes, salt: bytes, purpose: bytes) -> bytes:
    return HKDF(SHA256(), 32, salt, purpose).derive(key)


def _mac(key: bytes, head: bytes) -> bytes:
    return hmac.digest(_derived(key, b"", b"header"), head, "sha256")


def _nonce(number: int, last: bool) -> bytes:
    return number.to_bytes(11, "big") + bytes([last])


def _text(content: bytes) -> bytes:
    return base64.b64encode(content).rstrip(b"=")


def _bytes(text: bytes) -> bytes:
    return base64.b64decode(text + b"=" * (-len(text) % 4))
