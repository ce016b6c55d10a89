"""An archive to send to: its address, how it is spoken to, and what it takes."""

import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from breastrig.core.settings_file import SettingsPart, checked, read_toml

TITLE = r"[^\\\x00-\x1f\x7f-\U0010ffff]{1,16}"  # of an application entity
DICOM = re.compile(rf"({TITLE})@(\[[0-9a-fA-F:.]+\]|[A-Za-z0-9._-]+):([0-9]{{1,5}})")
STOW = re.compile(r"https?://[^\s/@?#]+(/[^\s?#]*)?")
Name = Literal["report", "measures", "skin", "scan"]


class Node(SettingsPart):
    """One of both addresses, and where it needs more."""

    dicom: str = Field("", description="AE@HOST:PORT, for C-STORE")
    stow: str = Field("", description="http(s)://…, for STOW-RS")
    calling: Annotated[str, Field(pattern=f"^{TITLE}$")] = Field("BREASTRIG", description="our own AE title")
    tls: bool = Field(False, description="C-STORE over TLS")
    ca: Path | None = Field(None, description="PEM of who signed the archive's certificate; else the system's")
    certificate: Path | None = Field(None, description="PEM of our own certificate with its key")
    authorization: Path | None = Field(None, description="file with the Authorization header's value, for STOW-RS")
    identities: Path | None = Field(None, description="the hospital's file of codes")
    objects: tuple[Name, ...] = ("report", "measures", "skin", "scan")

    @model_validator(mode="after")
    def _has_one_address(self) -> "Node":
        if (self.dicom == "") == (self.stow == ""):
            raise ValueError("give one address, dicom or stow")
        if self.dicom and (not (found := DICOM.fullmatch(self.dicom)) or not 0 < int(found[3]) < 65536):
            raise ValueError("dicom is AE@HOST:PORT with an AE title of at most 16 characters")
        if self.stow and not STOW.fullmatch(self.stow):
            raise ValueError("stow is http(s)://HOST/PATH without user, password and query")
        if self.authorization and not self.stow.startswith("https:"):
            raise ValueError("authorization is sent over https alone")
        return self

    @property
    def shown(self) -> str:
        return self.dicom or self.stow

    @property
    def called(self) -> tuple[str, str, int]:
        """(AE title, host, port)"""
        title, host, port = DICOM.fullmatch(self.dicom).groups()  # type: ignore[union-attr]  # checked above
        return title.strip(), host.strip("[]"), int(port)


def node(**said: Any) -> Node:
    """BadSettings with one sentence where these are no node."""
    return checked(Node, said, "This is no archive to send to")


def nodes_of(file: Path) -> dict[str, Node]:
    """The nodes of a TOML file, a table [NAME] each; BadSettings with one sentence."""
    tables = read_toml(file, "archives", "write a table [NAME] for each")
    return {name: checked(Node, table, f"{file}: [{name}] is no archive to send to") for name, table in tables.items()}
