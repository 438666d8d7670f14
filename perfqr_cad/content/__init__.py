"""What a code says: texts made of parts, with the escapes of their forms. Nothing here knows of symbols."""

from perfqr_cad.content.message import CONTENTS, link, message

__all__ = ["CONTENTS", "link", "message"]
