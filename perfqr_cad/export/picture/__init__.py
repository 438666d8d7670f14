"""The PNG picture: how the part lies or stands (`view`), the ray caster, and linear light as sRGB (`tone`).

For people's eyes only: what decoders are shown comes from `scan.camera`.
"""

from perfqr_cad.export.picture.view import rendered, write

__all__ = ["rendered", "write"]
