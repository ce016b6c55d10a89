"""Our files are opened by another program's age and the other way round; each damage is one sentence."""

import base64
import hashlib
import io
import random
from collections.abc import Callable

import pytest
from pyrage import passphrase as other

from breastrig.backup import age
from breastrig.backup.age import CHUNK, DAMAGED, NO_BACKUP, WRONG, SealedReader, SealedWriter
from breastrig.core.errors import BadInput

WORDS = "correct horse battery staple"
VECTOR = (  # little work for scrypt, which programs of others ask a second for
    b"age-encryption.org/v1\n"
    b"-> scrypt rF0/NwblUHHTpgQgRpe5CQ 10\n"
    b"gUjEymFKMVXQEKdMMHL24oYexjE3TIC0O0zGSqJ2aUY\n"
    b"--- IOXiQYStkoT1mvZW2tFOqZdhRVvj58egABx/sWfZQbc\n"
) + base64.b64decode("GzXG5ofdANo6w3msn3QsIf0YWhuePe1znRSsappQEk24Ztg=")


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(age, "WORK", 4)


def sealed(content: bytes) -> bytes:
    file = io.BytesIO()
    writer = SealedWriter(file, WORDS)
    for start in range(0, len(content), 50_001):
        writer.write(content[start : start + 50_001])
    writer.close()
    return file.getvalue()


def opened(content: bytes, passphrase: str = WORDS) -> bytes:
    reader = SealedReader(io.BytesIO(content), passphrase)
    parts = []
    while part := reader.read(70_000):
        parts.append(part)
    return b"".join(parts)


@pytest.mark.parametrize("size", [0, 1, CHUNK - 1, CHUNK, CHUNK + 1, 3 * CHUNK, 200_000])
def test_another_program_opens_ours_and_we_open_its(size: int) -> None:
    content = random.Random(size).randbytes(size)
    assert other.decrypt(sealed(content), WORDS) == content
    assert opened(sealed(content)) == content


def test_we_open_files_of_another_program() -> None:
    """A test vector of the format's authors (C2SP/CCTV, age/testdata/scrypt)."""
    content = opened(VECTOR, "password")
    assert hashlib.sha256(content).hexdigest() == "013f54400c82da08037759ada907a8b864e97de81c088a182062c4b5622fd2ab"
    assert other.decrypt(VECTOR, "password") == content


def flipped(content: bytes, place: int) -> bytes:
    return content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :]


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda whole: whole[:100], DAMAGED),
        (lambda whole: whole[: -CHUNK // 2], DAMAGED),
        (lambda whole: whole[: whole.index(b"---") + 48 + 16 + 2 * (CHUNK + 16)], DAMAGED),
        (lambda whole: whole[:32] + b"AAAA" + whole[36:], WRONG),  # the salt: as good as another passphrase
        (lambda whole: flipped(whole, whole.index(b"---") + 10), DAMAGED),
        (lambda whole: flipped(whole, len(whole) - 5), DAMAGED),
        (lambda whole: flipped(whole, 70_000), DAMAGED),
        (lambda whole: whole + b"x", DAMAGED),
        (lambda _whole: b"PK\3\4" + bytes(500), NO_BACKUP),
        (lambda _whole: b"", NO_BACKUP),
    ],
)
def test_damage_is_said(damage: Callable[[bytes], bytes], said: str) -> None:
    whole = sealed(random.Random(2).randbytes(3 * CHUNK + 100))
    with pytest.raises(BadInput) as error:
        opened(damage(whole))
    assert str(error.value) in ((said, DAMAGED) if said == DAMAGED else (said,))


def test_a_wrong_passphrase_is_said() -> None:
    with pytest.raises(BadInput, match="The passphrase is not the one"):
        opened(sealed(b"content"), "another")
